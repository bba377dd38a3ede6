"""Relation of an alternative to the answer: mirror image, rotation, variation, or other."""

from enum import StrEnum
from typing import Final

import numpy as np

from solver.arrays import FloatArray

_FIT: Final = 0.5
"""Residual below which one placement of the points is taken for another: root mean square of the
distances, in units of that of the distances from the centroid. Limbs that are bent on one side only
leave half of it."""

_GAIN: Final = 0.75
"""Share of the residual without a map that an orthogonal map must fall below to describe the
alternative."""

_TURN: Final = np.cos(np.pi / 4.0)
"""Cosine of the least angle that is called a rotation."""


class Relation(StrEnum):
    """Relation of an alternative to the answer; a variation differs from it in parts."""

    MIRROR_IMAGE = "mirror_image"
    ROTATION = "rotation"
    VARIATION = "variation"
    OTHER = "other"


def relation(answer: FloatArray, alternative: FloatArray) -> Relation:
    """Classify an alternative by the orthogonal map of its images onto those of the answer.

    The orthogonal Procrustes problem is solved among rotations and among reflections (Kabsch 1976).

    Parameters
    ----------
    answer, alternative
        (K, 3) positions on the target that the answer and the alternative give the same K points,
        in any unit of length.

    Returns
    -------
    Relation
        `Relation.OTHER` if there is no such point.
    """
    if not len(answer):
        return Relation.OTHER
    here, there = answer - answer.mean(axis=0), alternative - alternative.mean(axis=0)
    size = max(float((here**2).sum()), 1e-300)
    left, singular, right = np.linalg.svd(there.T @ here)
    sign = 1.0 if np.linalg.det(left @ right) > 0.0 else -1.0
    squares = size + float((there**2).sum()) - 2.0 * float(singular[:2].sum())
    rotated, mirrored = squares - 2.0 * sign * singular[2], squares + 2.0 * sign * singular[2]
    same = float(((answer - alternative) ** 2).sum())
    if min(rotated, mirrored) < min(_FIT**2 * size, _GAIN**2 * same):
        if mirrored < rotated:
            return Relation.MIRROR_IMAGE
        turn = left @ np.diag([1.0, 1.0, sign]) @ right
        if np.trace(turn) < 1.0 + 2.0 * _TURN:
            return Relation.ROTATION
    return Relation.VARIATION if same < _FIT**2 * size else Relation.OTHER
