"""Results of matches as arrays."""

from io import BytesIO

import numpy as np
import pytest
from numpy.typing import NDArray

from broker.contracts import MatchParameters, MatchPayload, MatchResult
from solver.control import Control
from solver.mesh import TriangleMesh
from tests.solver import shapes
from worker.jobs import MatchInput, match_shapes
from worker.jobs.match_results import arrays_of


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
    assert found["refined_vertices"].shape == found["refined_weights"].shape == (12, 3)
    np.testing.assert_allclose(found["refined_weights"].sum(axis=1), 1.0)
    one = result.refinement.points[5]
    assert tuple(found["refined_vertices"][5]) == one.vertices
