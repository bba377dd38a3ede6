"""Results of matches as arrays."""

import json
import re
from dataclasses import replace
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from isomatch import Match
from numpy.typing import NDArray

from broker import contracts
from broker.contracts import MatchParameters, MatchPayload, MatchResult
from solver.control import Control
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh
from solver.registration import Confidence, DenseCorrespondence
from solver.shape import Shape
from tests.solver import shapes
from worker.jobs import MatchInput, match_shapes
from worker.jobs.match_results import arrays_of, document_of


def answer(target: TriangleMesh | None = None, **changes: object) -> MatchResult:
    parameters = MatchParameters.model_validate({"points": 12, **changes})
    payload = MatchPayload(source="a", target="b", parameters=parameters)
    mesh = shapes.blob(2)
    other, _ = shapes.permuted(shapes.moved(target or mesh, 2), seed=1)
    return match_shapes(MatchInput(mesh, None), MatchInput(other, None), payload, Control())


def arrays(result: MatchResult) -> dict[str, NDArray[np.generic]]:
    with np.load(BytesIO(arrays_of(result)), allow_pickle=False) as stored:
        return dict(stored)


def test_costs_of_the_pairs_sum_to_the_energy() -> None:
    result = answer()
    found = arrays(result)
    assert set(found) == {"source", "target", "costs", "unmatched"}
    assert [found[name].dtype.name for name in ("source", "target", "costs", "unmatched")] == [
        "int64", "int64", "float64", "int64"
    ]  # fmt: skip
    pairs = [(pair.source, pair.target) for pair in result.correspondences]
    assert list(zip(found["source"].tolist(), found["target"].tolist(), strict=True)) == pairs
    assert found["costs"].sum() == pytest.approx(result.energy)


def test_unmatched_points_are_listed() -> None:
    """On a sphere most points are cheaper to leave unmatched."""
    result = answer(shapes.icosphere(2), occlusion_cost=0.01)
    found = arrays(result)
    assert len(found["unmatched"]) > 0
    assert found["unmatched"].tolist() == list(result.unmatched)
    assert len(found["source"]) + len(found["unmatched"]) == 12


def test_dense_and_refined_matches_have_more_arrays() -> None:
    result = answer(dense=True, refine="gmds")
    found = arrays(result)
    assert result.dense is not None
    assert result.refinement is not None
    assert found["dense_source"].tolist() == list(range(shapes.blob(2).n_vertices))
    assert found["dense_target"].tolist() == list(result.dense.target)
    faces, barycentric = found["dense_faces"], found["dense_barycentric"]
    assert faces.shape == barycentric.shape == (shapes.blob(2).n_vertices, 3)
    assert (faces[np.arange(len(faces)), barycentric.argmax(axis=1)] == found["dense_target"]).all()
    assert found["refined_vertices"].shape == found["refined_weights"].shape == (12, 3)
    np.testing.assert_allclose(found["refined_weights"].sum(axis=1), 1.0)
    one = result.refinement.points[5]
    assert tuple(found["refined_vertices"][5]) == one.vertices


def test_a_refined_match_without_pairs_has_arrays_of_no_rows() -> None:
    parameters = MatchParameters(points=6, occlusion_cost=1e-9, refine="gmds", orientation=False)
    payload = MatchPayload(source="a", target="b", parameters=parameters)
    source, target = MatchInput(shapes.torus(), None), MatchInput(shapes.blob(2), None)
    result = match_shapes(source, target, payload, Control())
    assert result.refinement is not None
    assert (result.correspondences, result.refinement.points) == ((), ())
    found = arrays(result)
    assert found["refined_vertices"].shape == found["refined_weights"].shape == (0, 3)


def document(**changes: Any) -> MatchResult:
    """The document of a small match, with parts of it replaced."""
    source = Shape(shapes.blob(2))
    found = match(source, source, MatchOptions(points=6, coarse_points=6, orientation=False))
    payload = MatchPayload(source="a", target="b", parameters=MatchParameters())
    return document_of(replace(found, **changes), payload, source.mesh)


def test_confidence_is_that_of_the_solver() -> None:
    assert document().confidence is None
    told = document(confidence=Confidence(0.31, ("the mirror image fits nearly as well",)))
    assert told.confidence == contracts.Confidence(
        probability=0.31, reasons=("the mirror image fits nearly as well",)
    )


def test_images_are_rounded_and_stay_in_their_triangles() -> None:
    rng = np.random.default_rng(7)
    weights = rng.dirichlet(np.full(3, 0.3), size=500)
    weights[:3] = np.eye(3)
    weights[3] = 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0
    # Rounding of the solver.
    weights[4] = -1e-17, 0.5, 0.5
    places = np.arange(500, dtype=np.int64)
    faces = rng.integers(0, 99, size=(500, 3))
    told = document(dense=DenseCorrespondence(places, places, faces, weights, 0)).dense
    assert told is not None
    assert [list(row) for row in told.faces] == faces.tolist()
    found = np.array(told.barycentric)
    assert found.min() >= 0.0
    np.testing.assert_allclose(found.sum(axis=1), 1.0, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(found, weights, rtol=0.0, atol=2e-4)
    assert max(len(text) for text in re.findall(r"[\d.e-]+", json.dumps(told.barycentric))) <= 6


def test_the_distance_of_the_samples_is_in_the_document() -> None:
    result = answer(objective="linf", points=10, metric="geodesic")
    found = result.gromov_hausdorff_distance
    assert found is not None
    # The target is the source, moved and with its vertices in another order.
    assert (found.points, found.certified, found.gap) == (10, True, 0.0)
    assert found.value == pytest.approx(0.0, abs=1e-9)
    assert {pair.source for pair in found.correspondences} == {
        pair.source for pair in result.correspondences
    }
    read = Match.model_validate_json(result.model_dump_json())
    assert read.gromov_hausdorff_distance is not None
    assert read.gromov_hausdorff_distance.value == found.value
    assert answer(proof="candidates", objective="linf").gromov_hausdorff_distance is None
    assert answer().gromov_hausdorff_distance is None
