"""Results of consistent maps: a wrong map among right ones, and a shape that cannot be mapped."""

from io import BytesIO
from itertools import combinations

import numpy as np
from scipy.spatial import KDTree

from broker.contracts import ConsistentMapsPayload, MatchParameters
from solver.arrays import IntArray
from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import Confidence, DenseCorrespondence
from solver.shape import Shape
from tests.solver.consistency.test_improvement import error, figures
from tests.solver.shapes import icosphere
from worker.jobs.consistent_map_results import Collection, PairwiseMap, consistent_maps_of

__all__ = ["figures"]

IDS = ("parts", "a", "b", "c", "d")


def dense(forward: IntArray, backward: IntArray) -> DenseCorrespondence:
    """A map that goes to vertices."""

    def one(images: IntArray, inverse: DenseCorrespondence | None) -> DenseCorrespondence:
        corners = np.repeat(images[:, None], 3, axis=1)
        weights = np.tile([1.0, 0.0, 0.0], (len(images), 1))
        return DenseCorrespondence(
            np.arange(len(images)), images, corners, weights, inverse=inverse
        )

    return one(forward, one(backward, None))


def test_a_replaced_map_is_named_by_the_shapes_it_went_through(
    figures: tuple[list[Shape], dict[tuple[int, int], IntArray], IntArray],
) -> None:
    shapes, truth, mirrored = figures
    wrong = dict(truth)
    wrong[0, 1], wrong[1, 0] = truth[0, 1][mirrored], mirrored[truth[1, 0]]
    reason = "it has only 4 vertices"
    sure, unsure = Confidence(0.95, ()), Confidence(0.2, ("doubt",))
    pairs: dict[tuple[int, int], PairwiseMap | str] = {
        (0, place): reason for place in range(1, len(IDS))
    }
    for i, j in combinations(range(len(shapes)), 2):
        confidence = unsure if (i, j) == (0, 1) else sure
        pairs[i + 1, j + 1] = PairwiseMap(dense(wrong[i, j], wrong[j, i]), confidence)
    payload = ConsistentMapsPayload(shapes=IDS, parameters=MatchParameters())
    collection = Collection((reason, *shapes), pairs)
    result, archive = consistent_maps_of(payload, [None] * len(IDS), collection, Control())
    changed = [one for one in result.pairs if one.through]
    assert [(one.source, one.target) for one in changed] == [("a", "b")]
    (one,) = changed
    assert one.through in {("c",), ("d",)}
    assert one.confidence_before is not None
    assert one.confidence_before.probability == 0.2
    assert one.confidence is not None
    assert one.confidence.probability > 0.8
    assert one.cycle_error_before is not None
    assert one.cycle_error is not None
    assert one.cycle_error_before > 0.1 > one.cycle_error
    assert [shape.reason for shape in result.shapes] == [reason, None, None, None, None]
    assert not any(pair.mapped or pair.fits for pair in result.pairs if pair.source == "parts")
    with np.load(BytesIO(archive), allow_pickle=False) as arrays:
        found = dict(arrays)
    assert error(shapes, found["map_1_2"], truth[0, 1], 1) < 0.05
    assert error(shapes, found["map_2_1"], truth[1, 0], 0) < 0.05
    for i, j in combinations(range(2, 5), 2):
        np.testing.assert_array_equal(found[f"map_{i}_{j}"], truth[i - 1, j - 1])


def test_a_shape_that_may_be_a_part_is_named() -> None:
    """Half a ball among balls."""
    ball = icosphere(3)
    upper = ball.vertices[ball.faces, 2].min(axis=1) > 0.0
    kept = np.unique(ball.faces[upper])
    bowl = triangle_mesh(ball.vertices[kept], np.searchsorted(kept, ball.faces[upper]))
    meshes = ball, ball, bowl
    nearest = [
        [
            np.asarray(KDTree(there.vertices).query(here.vertices)[1], dtype=np.int64)
            for there in meshes
        ]
        for here in meshes
    ]
    sure = Confidence(0.95, ())
    pairs: dict[tuple[int, int], PairwiseMap | str] = {
        (i, j): PairwiseMap(dense(nearest[i][j], nearest[j][i]), sure)
        for i, j in combinations(range(3), 2)
    }
    payload = ConsistentMapsPayload(shapes=IDS[1:4], parameters=MatchParameters())
    names = "ball", "other ball", "bowl"
    collection = Collection([Shape(mesh) for mesh in meshes], pairs)
    (said,) = consistent_maps_of(payload, names, collection, Control())[0].warnings
    assert "'bowl'" in said
    assert "ball" not in said
    assert "matched as wholes" in said
