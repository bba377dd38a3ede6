"""Degenerate faces: with a repeated corner, of zero area, or equal to another face."""

import numpy as np

from solver.errors import MeshError
from solver.mesh.normals import triangle_areas
from solver.mesh.repair.soup import TriangleSoup, groups_of_equal_rows

_ZERO_AREA = 1e-14
"""Twice a triangle's area over its longest edge squared, up to which it counts as zero: some tens
of rounding errors in double precision (2.2e-16)."""


def without_repeated_corners(soup: TriangleSoup) -> TriangleSoup:
    """Drop faces that use a vertex twice.

    Raises
    ------
    MeshError
        No face is left.
    """
    a, b, c = soup.faces.T
    return _with_any_faces(soup.with_faces((a != b) & (b != c) & (c != a), "using a vertex twice"))


def without_zero_area_faces(soup: TriangleSoup) -> TriangleSoup:
    """Drop faces whose corners lie on a line.

    Such a face (a *cap*) joins a long edge to the two short ones it consists of. Without it, the
    middle corner is a T-junction on the boundary edge of the neighbour: see ``t_junctions``.

    Raises
    ------
    MeshError
        No face is left.
    """
    a, b, c = (soup.unit_positions[soup.faces[:, corner]] for corner in range(3))
    longest = np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    double = 2.0 * triangle_areas(soup.unit_positions, soup.faces)
    return _with_any_faces(soup.with_faces(double > _ZERO_AREA * longest, "without area"))


def without_repeated_faces(soup: TriangleSoup) -> TriangleSoup:
    """Drop faces that have the corners of an earlier one, in whatever order."""
    first = groups_of_equal_rows(np.sort(soup.faces, axis=1).T)
    return soup.with_faces(first == np.arange(len(first)), "repeating others")


def _with_any_faces(soup: TriangleSoup) -> TriangleSoup:
    if not len(soup.faces):
        raise MeshError("no face has an area: all faces are degenerate")
    return soup
