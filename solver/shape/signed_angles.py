"""Signed angles between three points of an oriented surface: a third-order structure (7.1).

Distances do not tell a correspondence from its mirror image, and triples of points do: seen from
one of them, the direction to the second lies on the left or on the right of that to the third.
"""

import numpy as np

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh

RADIUS = 0.1
"""Radius over √area of the disc that an angle is averaged over: limbs and heads are as wide. At
half or twice the radius, fewer true maps of generated shapes have less third-order distortion than
their mirror images (``python -m bench.third_order``)."""

_LEAST_WEIGHT = 1e-3
"""Weight below which a triangle is left out: beyond 2.6 radii."""


def signed_angles(surface: TriangleMesh, distances: FloatArray, radius: float) -> FloatArray:
    """Mean sines of the angles of geodesic triangles, signed by the orientation of the surface.

    With w_x(z) = exp(−d(x, z)² / r²) and d_y = d(y, ·), the geodesic distance from y,

    > a(x, y, z) = ⅓ (A_x(y, z) + A_y(z, x) + A_z(x, y)),  A_x(y, z) = ∫ w_x dd_y ∧ dd_z.

    A gradient of a distance has length 1, so that dd_y ∧ dd_z is the sine of the angle from the
    direction to y to that to z, times the area. On a triangle it is the signed area of its image
    under (d_y, d_z): no normal, angle or area is needed, and short or thin triangles do no harm.
    In the plane a tends to ⅓ π r² (sin α + sin β + sin γ) for a small radius r, with the angles of
    the triangle x, y, z, if its corners are in counterclockwise order, and to minus that otherwise.

    Parameters
    ----------
    surface
        Consistently wound.
    distances
        (N, V) geodesic distances from the points to all vertices, in its unit of length.
    radius
        r, in the same unit.

    Returns
    -------
    (N, N, N) float64, in squared units of length. It changes its sign when two points are exchanged
    and when the surface is reflected or wound the other way round, and is invariant to bending.
    Time is O(N³ F') for F' triangles in a disc.
    """
    count = len(distances)
    corners, at_vertex = np.empty((count, count, count)), np.ascontiguousarray(distances.T)
    for own, at_corner in zip(distances, corners, strict=True):
        weights = np.exp(-((own / radius) ** 2))[surface.faces].mean(axis=1)
        near = np.flatnonzero(weights > _LEAST_WEIGHT)
        first, second, third = (at_vertex[vertices] for vertices in surface.faces[near].T)
        products = ((second - first) * weights[near, None]).T @ (third - first)
        at_corner[:] = 0.5 * (products - products.T)
    angles: FloatArray = corners + corners.transpose(1, 2, 0) + corners.transpose(2, 0, 1)
    return angles / 3.0
