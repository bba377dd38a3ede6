"""Congruent meshes: copies of one another but for a rigid motion and the order of vertices."""

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.registration.alignment import rotation_onto

_ROUNDS = 10
"""Of iterated closest points. From a registration, all vertices of a copy are met after two."""

_TOLERANCE = 1e-4
"""Distance over √area within which vertices coincide; files with six digits keep 1e-6."""


def congruent_vertices(
    source: TriangleMesh, target: TriangleMesh, images: IntArray
) -> IntArray | None:
    """Find the rigid motion that carries one mesh to another, from a map near it.

    Iterated closest points (Besl and McKay, "A method for registration of 3-D shapes", PAMI 14(2),
    1992), which end where the vertices do not come closer.

    Parameters
    ----------
    source, target
        Meshes of unit area; the source is reflected if the map is.
    images
        (V,) target vertices that those of the source go to.

    Returns
    -------
    (V,) the target vertex that each of the source coincides with, all of them; ``None`` if there
    is no such motion.
    """
    if source.n_vertices != target.n_vertices:
        return None
    here, there = source.vertices, target.vertices
    weights, tree, least = np.ones((len(here), 1)), KDTree(there), np.inf
    for _ in range(_ROUNDS):
        goals = there[images]
        turned = (here - here.mean(axis=0)) @ rotation_onto(here, goals, weights)
        away, nearest = map(np.asarray, tree.query(turned + goals.mean(axis=0)))
        images = nearest.astype(np.int64)
        if away.max() < _TOLERANCE:
            return _one_to_one(images, there)
        if away.mean() >= least:
            return None
        least = float(away.mean())
    return None


def _one_to_one(images: IntArray, there: FloatArray) -> IntArray | None:
    """Divide vertices at one place, as those where surfaces only touch, among their preimages."""
    place: IntArray = np.unique(there, axis=0, return_inverse=True)[1].reshape(-1)
    ours, theirs = (np.argsort(one, kind="stable") for one in (place[images], place))
    if not np.array_equal(place[images][ours], place[theirs]):
        return None
    found = np.empty_like(images)
    found[ours] = theirs
    return found
