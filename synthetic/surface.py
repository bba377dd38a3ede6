"""The skin of a figure as an even triangle mesh of a given size."""

from functools import lru_cache, partial

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from synthetic.implicit import body, marching_cubes_surface
from synthetic.remeshing import Surface, collapse_short_edges, flip_edges, onto, relax
from synthetic.skeleton import Figure

_LEAST_VERTICES = 200
_COARSEST_SPACING = 0.0125
"""Edge of grid cells, in metres, that still resolve the thinnest parts, fingers and nose."""

_FINE = 6000
"""Least vertices of the triangulation from which coarser ones are made."""


def skin(figure: Figure, resolution: int, seed: int) -> tuple[FloatArray, IntArray]:
    """Triangulate the skin of a figure in its rest pose.

    Parameters
    ----------
    figure
        The figure.
    resolution
        Number of vertices.
    seed
        Another seed gives another triangulation of the same surface.

    Returns
    -------
    vertices, faces
        (V, 3) float64 and (F, 3) int64: closed, oriented outwards, edges of nearly equal length.

    Raises
    ------
    OptionError
        `resolution` is less than 200.
    """
    if resolution < _LEAST_VERTICES:
        raise OptionError("resolution", f"needs at least {_LEAST_VERTICES} vertices")
    rng = np.random.default_rng(seed)
    surface = partial(body, figure.cones(), figure.blend)
    vertices, faces = _fine_skin(figure, max(2 * resolution, _FINE))
    while len(vertices) > resolution:
        before = len(vertices)
        count = max(resolution, before * 2 // 3)
        vertices, faces = collapse_short_edges(vertices, faces, surface, count, rng)
        if len(vertices) == before:
            break
        vertices, faces = _improve(vertices, faces, surface, 2, rng)
    vertices, faces = _improve(vertices, faces, surface, 8, rng)
    return onto(vertices, surface), faces


@lru_cache(maxsize=16)
def _fine_skin(figure: Figure, least: int) -> tuple[FloatArray, IntArray]:
    """The triangulation of at least so many vertices that all others of a figure start from."""
    rng = np.random.default_rng(0)
    cones = figure.cones()
    surface = partial(body, cones, figure.blend)
    offset = rng.random(3)
    vertices, faces = marching_cubes_surface(cones, figure.blend, _COARSEST_SPACING, offset)
    if len(vertices) < least:
        spacing = _COARSEST_SPACING * np.sqrt(len(vertices) / least)
        vertices, faces = marching_cubes_surface(cones, figure.blend, spacing, offset)
    vertices = relax(vertices, faces, surface, 2)
    while len(vertices) > 1.5 * least:
        count = max(least, len(vertices) * 2 // 3)
        vertices, faces = collapse_short_edges(vertices, faces, surface, count, rng)
        vertices, faces = _improve(vertices, faces, surface, 2, rng)
    return vertices, faces


def _improve(
    vertices: FloatArray, faces: IntArray, surface: Surface, rounds: int, rng: np.random.Generator
) -> tuple[FloatArray, IntArray]:
    for _ in range(rounds):
        faces = flip_edges(vertices, faces, rng)
        vertices = relax(vertices, faces, surface, 2)
    return vertices, flip_edges(vertices, faces, rng)
