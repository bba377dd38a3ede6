"""A part, through the whole chain: in the numbers of the users' own files."""

import httpx2
import numpy as np
import pytest

from solver.arrays import BoolArray
from solver.mesh import TriangleMesh, triangle_mesh
from synthetic import SyntheticShape, human, submesh
from tests.service.conftest import Upload, problem
from tests.service.matching import matched
from tests.solver.mesh.mesh_files import file_of


def whole_and_part() -> tuple[TriangleMesh, TriangleMesh]:
    """A body, and the same without what is above its shoulders, twice as large."""
    body = human("walking", resolution=800)
    height = body.vertices[:, 1] / np.ptp(body.vertices[:, 1])
    part = part_of(body, height >= height.max() - 0.2, 2.0)
    return triangle_mesh(body.vertices, body.faces), part


def part_of(body: SyntheticShape, lacking: BoolArray, scale: float) -> TriangleMesh:
    """A body without some of its vertices, in other units."""
    whole = triangle_mesh(scale * body.vertices, body.faces)
    return submesh(whole, ~np.any(lacking[whole.faces], axis=1))[1]


@pytest.fixture(scope="module")
def files() -> tuple[bytes, bytes]:
    whole, part = whole_and_part()
    return file_of(whole), file_of(part)


def test_vertices_without_a_partner_are_left_out(
    http: httpx2.Client, upload: Upload, files: tuple[bytes, bytes]
) -> None:
    whole, part = (upload(one, "m.ply")["id"] for one in files)
    lowest = [int(one.vertices[:, 1].argmin()) for one in whole_and_part()]
    options = {"dense": True, "partial": "target", "landmarks": [lowest]}
    job = matched(http, (whole, part), points=12, **options)
    result = http.get(job["links"]["result"]).json()
    pairs = [[one["source"], one["target"]] for one in result["correspondences"]]
    assert lowest in pairs
    overlap = result["overlap"]
    assert overlap["part"] == "target"
    assert overlap["scale"] == pytest.approx(2.0, rel=0.1)
    assert 0.5 < overlap["source"] < 1.0 == overlap["target"]
    found = result["dense"]
    assert len(found["source"]) < 800
    assert len(result["correspondences"]) + len(result["unmatched"]) == 12
    assert set(result["unmatched"]).isdisjoint(one["source"] for one in result["correspondences"])
    for link in (".png", ".glb", ".csv", ".npz"):
        assert http.get(job["links"]["result"] + link).status_code == 200


def test_a_part_that_is_matched_as_a_whole_is_named(
    http: httpx2.Client, upload: Upload, files: tuple[bytes, bytes]
) -> None:
    whole, part = (upload(one, "m.ply")["id"] for one in files)
    warned = []
    for asked in ("none", "detected"):
        job = matched(http, (whole, part), points=4, orientation=False, partial=asked)
        warnings = http.get(job["links"]["result"]).json()["warnings"]
        warned.append([one for one in warnings if "long boundary" in one])
    assert ["'target'" in one for one in warned[0]] == [True]
    assert warned[1] == []


def test_two_parts_are_matched(http: httpx2.Client, upload: Upload) -> None:
    """A body without its head, and the same in another pose without a foot, half as large."""
    walking, standing = (human(pose, resolution=800) for pose in ("walking", "standing"))
    height = standing.rest[:, 1] / np.ptp(standing.rest[:, 1])
    low = (height < height.min() + 0.25) & (standing.rest[:, 0] > 0.0)
    source = part_of(walking, height > height.max() - 0.15, 1.0)
    target = part_of(standing, low, 0.5)
    uploaded = [upload(file_of(one), "m.ply")["id"] for one in (source, target)]
    job = matched(http, (uploaded[0], uploaded[1]), points=12, dense=True, partial="both")
    result = http.get(job["links"]["result"]).json()
    overlap = result["overlap"]
    assert overlap["part"] == "both"
    assert overlap["scale"] == pytest.approx(0.5, rel=0.1)
    assert 0.5 < overlap["source"] < 1.0
    assert 0.5 < overlap["target"] < 1.0
    assert len(result["dense"]["source"]) < source.n_vertices
    assert len(result["dense"]["inverse"]["target"]) < target.n_vertices
    for link in (".png", ".glb", ".csv", ".npz"):
        assert http.get(job["links"]["result"] + link).status_code == 200


def test_an_unknown_part_is_refused(http: httpx2.Client) -> None:
    asked = {"source": "0" * 64, "target": "1" * 64, "partial": "either"}
    answer = http.post("/v1/matches", json=asked)
    assert "body.partial" in str(problem(answer, 422, "invalid-request"))


@pytest.mark.parametrize("partial", ["source", "both"])
@pytest.mark.parametrize(
    ("field", "options"),
    [
        ("partial", {"objective": "linf", "points": 8}),
        ("partial", {"refine": "gmds"}),
    ],
)
def test_options_without_meaning_for_parts_are_refused(
    http: httpx2.Client, partial: str, field: str, options: dict[str, object]
) -> None:
    asked = {"source": "0" * 64, "target": "1" * 64, "partial": partial, **options}
    answer = http.post("/v1/matches", json=asked)
    assert f"body.{field}" in str(problem(answer, 422, "invalid-request"))
