"""Precision of coordinates of shapes that lie far from the origin."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.repair.soup import TriangleSoup

_FAR = 64.0
"""Largest coordinate, in extents of the shape, up to which rounding of it does not matter."""

_WARNED, _REFUSED = 1e-3, 0.5
"""Spacing of the coordinates, in lengths of the median edge."""


def checked_precision(soup: TriangleSoup) -> TriangleSoup:
    """Note coarse coordinates of a shape that lies far from the origin.

    Floating-point numbers, and those written with so many digits, are the coarser the larger they
    are. Integers are not, and are not asked for more than that double precision holds them.

    Raises
    ------
    MeshError
        They are coarser than half a median edge.
    """
    magnitude = float(np.abs(soup.vertices).max())
    extent = float(np.ptp(soup.vertices, axis=0).max())
    if magnitude <= _FAR * extent:
        return soup
    grid = float(np.spacing(magnitude))
    if not soup.fixed_point:
        grid = _grid(soup.vertices, magnitude)
    edge = _typical_edge(soup.vertices, soup.faces)
    if grid <= _WARNED * edge:
        return soup
    where = (
        f"the shape lies {magnitude / extent:.3g} times its size from the origin, where its"
        f" coordinates are multiples of {grid:.3g}"
    )
    if grid > _REFUSED * edge:
        raise MeshError(f"{where}: its details are lost; move it to the origin before it is saved")
    return soup.noting(
        f"{where}, {100.0 * grid / edge:.3g} % of a typical edge: distances are no more precise;"
        " move it to the origin before it is saved"
    )


def _grid(vertices: FloatArray, magnitude: float) -> float:
    """Spacing of the numbers that coordinates were rounded to.

    The coarsest of double precision, single precision and 3 to 9 decimal digits that holds all of
    them.
    """
    grid = double = float(np.spacing(magnitude))
    if (
        magnitude < float(np.finfo(np.float32).max)
        and (vertices.astype(np.float32) == vertices).all()
    ):
        grid = float(np.spacing(np.float32(magnitude)))
    for digits in range(3, 10):
        decimal = 10.0 ** (np.floor(np.log10(magnitude)) + 1.0 - digits)
        if np.abs(vertices - decimal * np.rint(vertices / decimal)).max() <= 2.0 * double:
            return max(grid, float(decimal))
    return grid


def _typical_edge(vertices: FloatArray, faces: IntArray) -> float:
    lengths = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, -1, axis=1)], axis=2)
    return float(np.median(lengths))
