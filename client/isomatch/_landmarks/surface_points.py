"""Points of a surface that are nearest to positions in space."""

from typing import Final

import numpy as np
import numpy.typing as npt

from isomatch._results import Geometry

Floats = npt.NDArray[np.float64]

_EDGES: Final = ((0, 1), (1, 2), (2, 0))


def nearest_points(geometry: Geometry, positions: Floats) -> Floats:
    """Return the points of a surface nearest to positions in space, (n, 3).

    Parameters
    ----------
    geometry
        The surface, with F triangles.
    positions
        (n, 3) finite. Each takes O(F).
    """
    corners = geometry.vertices[geometry.faces]
    middles = corners.mean(axis=1)
    radii = np.sqrt(((corners - middles[:, None]) ** 2).sum(axis=2).max(axis=1))
    used = geometry.vertices[np.unique(geometry.faces)]
    found = np.empty((len(positions), 3))
    for row, position in enumerate(positions):
        bound = _distances(used, position).min()
        # The tolerance keeps the triangles of the nearest vertex despite rounding.
        near = _distances(middles, position) - radii <= bound * (1.0 + 1e-9) + 1e-12 * radii
        found[row] = _nearest_in_triangles(corners[near], position)
    return found


def square_root_of_area(geometry: Geometry) -> float:
    """Return the unit of relative lengths."""
    a, b, c = np.moveaxis(geometry.vertices[geometry.faces], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    return float(np.sqrt(area))


def _nearest_in_triangles(triangles: Floats, position: Floats) -> Floats:
    """The nearest point of (m, 3, 3) triangles, (3,)."""
    found = np.zeros((len(triangles), 4, 3))
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    offset = position - triangles[:, 0]
    uu, uv, vv = _dots(u, u), _dots(u, v), _dots(v, v)
    determinant = np.maximum(uu * vv - uv * uv, np.finfo(float).tiny)
    found[:, 3, 1] = (vv * _dots(u, offset) - uv * _dots(v, offset)) / determinant
    found[:, 3, 2] = (uu * _dots(v, offset) - uv * _dots(u, offset)) / determinant
    found[:, 3, 0] = 1.0 - found[:, 3, 1] - found[:, 3, 2]
    for place, (first, second) in enumerate(_EDGES):
        edge = triangles[:, second] - triangles[:, first]
        length = np.maximum(_dots(edge, edge), np.finfo(float).tiny)
        along = (_dots(position - triangles[:, first], edge) / length).clip(0.0, 1.0)
        found[:, place, first], found[:, place, second] = 1.0 - along, along
    places = np.einsum("mkc,mcd->mkd", found, triangles)
    squares = ((places - position) ** 2).sum(axis=2)
    # The foot of the perpendicular counts only within its triangle.
    squares[(found[:, 3] < 0.0).any(axis=1), 3] = np.inf
    nearest: Floats = places.reshape(-1, 3)[squares.argmin()]
    return nearest


def _dots(a: Floats, b: Floats) -> Floats:
    found: Floats = (a * b).sum(axis=1)
    return found


def _distances(points: Floats, position: Floats) -> Floats:
    found: Floats = np.sqrt(((points - position) ** 2).sum(axis=1))
    return found
