"""Straightest paths on a triangulated surface, from triangle to triangle."""

import numpy as np

from solver.arrays import FloatArray
from solver.gmds.surface import Charts
from solver.kernel import kernel

_MOST_CROSSINGS = 1000
"""Edges that a line may cross; it ends at the last of them."""


@kernel
def walk(charts: Charts, face: int, u: FloatArray, x: float, y: float) -> tuple[int, FloatArray]:
    """Follow a straight line on the surface.

    A line that crosses an edge goes on in the plane into which both triangles unfold. At the
    boundary of the surface, the rest of it slides along the edge, to its end at most.

    Parameters
    ----------
    charts
        Of the surface.
    face, u
        Where the line begins: a triangle and (3,) barycentric coordinates.
    x, y
        The line as a vector in the plane of that triangle.

    Returns
    -------
    face, u
        Where it ends.
    """
    here = u.copy()
    pace = np.empty(3)
    for _ in range(_MOST_CROSSINGS):
        _pace(charts.corners[face], x, y, pace)
        share, side = _exit(here, pace)
        for corner in range(3):
            here[corner] = max(here[corner] + share * pace[corner], 0.0)
        if side >= 0:
            here[side] = 0.0
        here /= here.sum()
        if side < 0:
            break
        x, y = x * (1.0 - share), y * (1.0 - share)
        beyond = charts.neighbours[face, side]
        if beyond < 0:
            _slide(charts.corners[face], here, side, x, y)
            break
        face, x, y = _cross(charts, face, beyond, side, here, x, y)
    return face, here


@kernel
def _pace(corners: FloatArray, x: float, y: float, pace: FloatArray) -> None:
    """Change of the barycentric coordinates along a vector."""
    pace[2] = y / corners[2]
    pace[1] = (x - pace[2] * corners[1]) / corners[0]
    pace[0] = -pace[1] - pace[2]


@kernel
def _exit(u: FloatArray, pace: FloatArray) -> tuple[float, int]:
    """Share of the way that stays inside, and the corner opposite which it leaves; -1 if not."""
    share, side = 1.0, -1
    for corner in range(3):
        if pace[corner] < 0.0 and u[corner] < -share * pace[corner]:
            share, side = u[corner] / -pace[corner], corner
    return share, side


@kernel
def _corner(corners: FloatArray, which: int) -> tuple[float, float]:
    if which == 0:
        return 0.0, 0.0
    if which == 1:
        return corners[0], 0.0
    return corners[1], corners[2]


@kernel
def _axes(corners: FloatArray, start: int, end: int, apex: int) -> tuple[float, float, float, bool]:
    """Unit vector along an edge, the edge's length, and whether the apex lies to its left."""
    x0, y0 = _corner(corners, start)
    x1, y1 = _corner(corners, end)
    x2, y2 = _corner(corners, apex)
    length = np.hypot(x1 - x0, y1 - y0)
    x, y = (x1 - x0) / length, (y1 - y0) / length
    return x, y, length, (x2 - x0) * -y + (y2 - y0) * x > 0.0


@kernel
def _slide(corners: FloatArray, u: FloatArray, side: int, x: float, y: float) -> None:
    """Move along the edge opposite `side` as far as a vector points along it."""
    start, end = (side + 1) % 3, (side + 2) % 3
    along_x, along_y, length, _ = _axes(corners, start, end, side)
    share = (x * along_x + y * along_y) / length
    u[end] = min(max(u[end] + share, 0.0), 1.0)
    u[start] = 1.0 - u[end]


@kernel
def _cross(
    charts: Charts, face: int, beyond: int, side: int, u: FloatArray, x: float, y: float
) -> tuple[int, float, float]:
    """Enter the triangle beyond an edge: renew `u`, and return it and the rest of the way."""
    start, end = (side + 1) % 3, (side + 2) % 3
    ax, ay, _, left = _axes(charts.corners[face], start, end, side)
    along = x * ax + y * ay
    outward = x * -ay + y * ax
    if left:
        outward = -outward
    new_start, new_end = 0, 0
    for corner in range(3):
        if charts.faces[beyond, corner] == charts.faces[face, start]:
            new_start = corner
        if charts.faces[beyond, corner] == charts.faces[face, end]:
            new_end = corner
    weight_start, weight_end = u[start], u[end]
    u[:] = 0.0
    u[new_start], u[new_end] = weight_start, weight_end
    apex = 3 - new_start - new_end
    bx, by, _, new_left = _axes(charts.corners[beyond], new_start, new_end, apex)
    inward = outward if new_left else -outward
    return beyond, along * bx - inward * by, along * by + inward * bx
