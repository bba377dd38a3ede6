"""Damaged, large and poisonous meshes through the whole chain: upload, warnings, match, names."""

import struct

import httpx2
import numpy as np
import pytest

from solver.mesh import read_mesh
from solver.shape import Shape
from tests.service.conftest import Upload, problem
from tests.service.matching import matched
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.mesh.repair.damage import (
    HARMLESS,
    REFUSED,
    Damage,
    Damaged,
    coordinates,
    degenerate,
    distorting,
    name_of,
    numbering,
    repetition,
    seams,
)

QUICK = {"points": 8, "eigenpairs": 30, "orientation": False}


def ply(damaged: Damaged) -> bytes:
    return mesh_files.ply(damaged.vertices, damaged.faces)


def pairs(http: httpx2.Client, source: str, target: str, **parameters: object) -> list[list[int]]:
    job = matched(http, (source, target), **(QUICK | parameters))
    result = http.get(job["links"]["result"]).json()
    return [[pair["source"], pair["target"]] for pair in result["correspondences"]]


@pytest.mark.parametrize(
    "cause",
    [
        numbering.unused_vertices_without_place,
        repetition.all_twice_and_turned,
        seams.loose_faces_turned_at_random,
        degenerate.needles,
        degenerate.t_junctions_and_seams,
        coordinates.huge,
        coordinates.moved_by_a_hundred_million,
    ],
    ids=name_of,
)
def test_a_repaired_mesh_is_matched_by_the_numbers_of_its_file(
    http: httpx2.Client, upload: Upload, cause: Damage
) -> None:
    original, damaged = shapes.blob(3), cause(shapes.blob(3))
    told = HARMLESS[cause]
    sound = upload(mesh_files.ply(original.vertices, original.faces.tolist()), "a.ply")
    shape = upload(ply(damaged), "b.ply")
    assert any(told in warning for warning in shape["warnings"]) if told else not shape["warnings"]
    assert (shape["components"], shape["closed"]) == (1, True)
    assert shape["area"] == pytest.approx(original.area * damaged.scale**2, rel=1e-5)
    numbers = {int(number): vertex for vertex, number in enumerate(damaged.where)}
    found = pairs(http, shape["id"], sound["id"])
    assert [numbers[source] for source, _ in found] == [target for _, target in found]


@pytest.mark.parametrize("cause", REFUSED, ids=name_of)
def test_unsound_surfaces_are_refused_with_the_reason(http: httpx2.Client, cause: Damage) -> None:
    data = ply(cause(shapes.blob(3)))
    answer = http.post("/v1/shapes", files={"file": ("m.ply", data)})
    document = problem(answer, 422, "unusable-mesh")
    assert REFUSED[cause] in document["detail"]


def test_a_result_repeats_what_was_repaired(http: httpx2.Client, upload: Upload) -> None:
    shape = upload(ply(distorting.a_fin(shapes.blob(3))), "fin.ply")["id"]
    job = matched(http, (shape, shape), **QUICK)
    warnings = http.get(job["links"]["result"]).json()["warnings"]
    for side in ("source", "target"):
        assert any(side in text and "more than two faces" in text for text in warnings)


def test_simplified_shapes_are_matched_by_vertices_of_their_files(
    http: httpx2.Client, upload: Upload
) -> None:
    mesh = shapes.blob(4)
    other, where = shapes.permuted(shapes.moved(mesh, 4), seed=8)
    files = [mesh_files.ply(m.vertices, m.faces.tolist()) for m in (mesh, other)]
    source, target = (upload(data, "m.ply") for data in files)
    job = matched(http, (source["id"], target["id"]), **QUICK, simplify=300)
    result = http.get(job["links"]["result"]).json()
    for side in ("source", "target"):
        told = [text for text in result["warnings"] if text.startswith(side)]
        assert "simplified from 2562 to 300 vertices" in told[0]
    found = np.array([[pair["source"], pair["target"]] for pair in result["correspondences"]])
    distances = Shape(read_mesh(files[1], "ply")).metric("geodesic").distances(where[found[:, 0]])
    assert distances[np.arange(8), found[:, 1]].mean() < 0.06
    # It is no answer about the whole shapes: these have spectra of their own.
    whole = pairs(http, source["id"], target["id"])
    assert [target for _, target in whole] == where[[source for source, _ in whole]].tolist()
    assert http.get(job["links"]["result"] + ".png").status_code == 200


POISON = {
    "off that promises all": ("off", b"OFF\n%d %d 0\n0 0 0\n" % (2**62, 2**62)),
    "stl that promises all": ("stl", bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(60)),
    "ply lists in lists": (
        "ply",
        b"ply\nformat binary_little_endian 1.0\nelement face 1000000\n"
        b"property list uint uchar vertex_indices\nend_header\n" + b"\xff" * 4000,
    ),
    "gltf nested": ("gltf", b'{"a":' * 30_000 + b"1" + b"}" * 30_000),
    "gltf arrays nested": ("gltf", b"[" * 200_000),
    "zip": ("obj", b"PK\x03\x04" + bytes(5000)),
    "gzip": ("ply", b"\x1f\x8b\x08" + bytes(5000)),
    "a polygon without end": (
        "obj",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + b"1 2 3 " * 100_000 + b"\n",
    ),
    "all vertices in one place": (
        "off",
        b"OFF\n40000 13333 0\n" + b"1 1 1\n" * 40_000
        + b"".join(b"3 %d %d %d\n" % (3 * n, 3 * n + 1, 3 * n + 2) for n in range(13_333)),
    ),
    "all edges over one another": (
        "off",
        b"OFF\n15000 5000 0\n" + b"0 0 0\n1 0 0\n0.5 1 0\n" * 5000
        + b"".join(b"3 %d %d %d\n" % (3 * n, 3 * n + 1, 3 * n + 2) for n in range(5000)),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", POISON)
def test_poison_harms_only_its_own_job(http: httpx2.Client, upload: Upload, name: str) -> None:
    file_type, data = POISON[name]
    answer = http.post("/v1/shapes", files={"file": (f"m.{file_type}", data)})
    if answer.status_code != 201:
        packed = data.startswith(b"\x1f\x8b")
        problem(answer, *((415, "unsupported-format") if packed else (422, "unusable-mesh")))
    mesh = shapes.blob(2)
    assert upload(mesh_files.off(mesh.vertices, mesh.faces.tolist()), "fine.off")["vertices"] == 162
