"""Faces that are no triangles: with a corner twice, without area, or the same as another."""

import numpy as np

from solver.arrays import BoolArray, FloatArray
from solver.errors import MeshError
from solver.mesh.repair.soup import TriangleSoup, groups_of_equal_rows

_FLAT = 1e-14
"""Twice a triangle's area over its longest edge squared, below which it has no area to speak of:
some tens of rounding errors."""


def without_repeated_corners(soup: TriangleSoup) -> TriangleSoup:
    """Drop faces that use a vertex twice.

    Raises
    ------
    MeshError
        There is no other.
    """
    a, b, c = soup.faces.T
    return _some(soup.with_faces((a != b) & (b != c) & (c != a), "with a corner twice"))


def without_flat_faces(soup: TriangleSoup) -> TriangleSoup:
    """Drop faces whose corners lie on a line.

    Such a *cap* joins a long edge to the two short ones it consists of. Without it, the middle
    corner lies on the border edge of the neighbour: see ``junctions``.

    Raises
    ------
    MeshError
        There is no other.
    """
    return _some(soup.with_faces(~_flat(soup.places, soup), "without area"))


def without_repeated_faces(soup: TriangleSoup) -> TriangleSoup:
    """Drop faces that have the corners of an earlier one, in whatever order."""
    first = groups_of_equal_rows(np.sort(soup.faces, axis=1).T)
    return soup.with_faces(first == np.arange(len(first)), "with the corners of others")


def _flat(places: FloatArray, soup: TriangleSoup) -> BoolArray:
    a, b, c = (places[soup.faces[:, corner]] for corner in range(3))
    longest = np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    flat: BoolArray = np.linalg.norm(np.cross(b - a, c - a), axis=1) <= _FLAT * longest
    return flat


def _some(soup: TriangleSoup) -> TriangleSoup:
    if not len(soup.faces):
        raise MeshError("no face has an area: all of them are degenerate")
    return soup
