"""What an alternative is: named for the orthogonal map that makes it."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.matching import Relation, relation
from tests.solver import shapes

POINTS = shapes.blob(2).vertices[::7]
ABOUT = np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9])
REFLECTION = np.eye(3) - 2.0 * np.outer(ABOUT, ABOUT)
HALF_TURN = 2.0 * np.outer(ABOUT, ABOUT) - np.eye(3)


@pytest.mark.parametrize(
    ("made", "named"),
    [
        (POINTS @ REFLECTION + 2.0, Relation.MIRROR_IMAGE),
        (POINTS @ HALF_TURN - 1.0, Relation.ROTATION),
        (POINTS, Relation.VARIATION),
        (np.concatenate([POINTS[1::-1], POINTS[2:]]), Relation.VARIATION),
        (np.random.default_rng(4).permutation(POINTS), Relation.OTHER),
        (np.repeat(POINTS[:1], len(POINTS), axis=0), Relation.OTHER),
    ],
)
def test_names(made: FloatArray, named: Relation) -> None:
    assert relation(POINTS, made) is named
    # In any coordinates and unit.
    assert relation(3.0 * POINTS @ HALF_TURN + 5.0, 3.0 * made @ HALF_TURN + 5.0) is named


def test_without_points_in_common_it_is_another() -> None:
    """Where points may stay unmatched, an alternative may match none of those of the answer."""
    assert relation(POINTS[:0], POINTS[:0]) is Relation.OTHER
