"""Left-right symmetry of generated figures at rest, which is the reflection in the plane x = 0."""

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.registration.surface import MIRROR


def mirrored_vertices(rest: FloatArray) -> IntArray:
    """(V,) vertex nearest to the mirror image of each of (V, 3) vertices of a figure at rest."""
    found: IntArray = np.asarray(KDTree(rest).query(rest * MIRROR)[1], dtype=np.int64)
    return found
