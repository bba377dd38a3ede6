"""What is left of coordinates that lie far from the origin."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.repair.soup import TriangleSoup

_FAR = 64.0
"""Largest coordinate, in extents of the shape, up to which no digits to speak of are lost."""

_WORTH_SAYING, _TOO_COARSE = 1e-3, 0.5
"""Grid of the coordinates in lengths of a typical edge."""


_MOST_SINGLE = float(np.finfo(np.float32).max)


def checked_precision(soup: TriangleSoup) -> TriangleSoup:
    """Warn if the shape lies so far from the origin that its coordinates are coarse.

    Raises
    ------
    MeshError
        They are so coarse that the surface is lost.
    """
    magnitude = float(np.abs(soup.vertices).max())
    extent = float(np.ptp(soup.vertices, axis=0).max())
    if magnitude <= _FAR * extent:
        return soup
    grid = _grid(soup.vertices, magnitude)
    edge = _typical_edge(soup.vertices, soup.faces)
    if grid <= _WORTH_SAYING * edge:
        return soup
    where = (
        f"the shape lies {magnitude / extent:.2g} times its size from the origin, where its"
        f" coordinates are multiples of {grid:.2g}"
    )
    if grid > _TOO_COARSE * edge:
        raise MeshError(f"{where}: its form is lost; move it to the origin before it is saved")
    return soup.noting(
        f"{where}, {100.0 * grid / edge:.2g} % of a typical edge: distances are as uncertain;"
        " move it to the origin before it is saved"
    )


def _grid(vertices: FloatArray, magnitude: float) -> float:
    """Distance between the numbers that coordinates were rounded to.

    That is what double precision resolves, or single precision, or so many decimal digits,
    whatever is the coarsest that holds all coordinates.
    """
    grid = double = float(np.spacing(magnitude))
    if magnitude < _MOST_SINGLE and (vertices.astype(np.float32) == vertices).all():
        grid = float(np.spacing(np.float32(magnitude)))
    for digits in range(3, 10):
        decimal = 10.0 ** (np.floor(np.log10(magnitude)) + 1.0 - digits)
        if np.abs(vertices - decimal * np.rint(vertices / decimal)).max() <= 2.0 * double:
            return max(grid, float(decimal))
    return grid


def _typical_edge(vertices: FloatArray, faces: IntArray) -> float:
    lengths = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, -1, axis=1)], axis=2)
    return float(np.median(lengths))
