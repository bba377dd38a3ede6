"""Holes punched into surfaces, where they do not cut a limb off."""

import numpy as np

from solver.mesh import TriangleMesh
from synthetic import Transformed, punched


def with_holes(
    mesh: TriangleMesh, count: int, radius: float, seed: int = 0, least: int | None = None
) -> Transformed:
    """Punch holes at random places, where one of that size does not cut a limb off.

    Parameters
    ----------
    mesh
        A closed surface.
    count
        Number of holes.
    radius
        Their geodesic radius.
    seed
        Chooses the places.
    least
        Number of holes that will do where no more fit; `count` by default.

    Raises
    ------
    ValueError
        The surface is too thin for so many.
    """
    every = np.arange(mesh.n_vertices)
    found = Transformed(mesh, every, np.ones(mesh.n_vertices, dtype=np.bool_))
    centres: list[int] = []
    for centre in np.random.default_rng(seed).permutation(mesh.n_vertices):
        try:
            tried = punched(mesh, np.array([*centres, centre]), radius)
        except ValueError:
            continue
        if tried.mesh.components == 1:
            centres, found = [*centres, int(centre)], tried
        if len(centres) == count:
            return found
    if len(centres) < (count if least is None else least):
        raise ValueError("the surface is too thin for holes of that size")
    return found
