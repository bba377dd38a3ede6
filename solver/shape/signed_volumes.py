"""Signed volumes of triples of points of an oriented surface: a third-order structure (7.1).

Distances do not tell a correspondence from its mirror image. Triples of points do: their distances
to all points of the surface embed it in space, where it encloses a volume, whose sign is that of
the orientation.
"""

import numpy as np

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh

_BLOCK = 20_000
"""Triangles that are summed up at a time, so that memory does not grow with them."""


def signed_volumes(surface: TriangleMesh, functions: FloatArray) -> FloatArray:
    """Signed volumes that a surface encloses when three functions embed it in space.

    On a closed surface

    > a(f, g, h) = ∮ f dg ∧ dh

    is, by Stokes' theorem, the volume enclosed by the image of the surface under (f, g, h), counted
    with the orientation. It is alternating in the three functions, vanishes where one of them is a
    function of the others, and depends on the orientation, but on no metric. With functions that
    are linear on each triangle the integral is exact; on a surface with a border it is the mean of
    its three cyclic permutations.

    Parameters
    ----------
    surface
        Consistently wound.
    functions
        (N, V) values at the vertices.

    Returns
    -------
    (N, N, N) float64, in the cubed unit of the functions. Time is O(N³ F).

    Examples
    --------
    >>> import numpy as np
    >>> from solver.mesh import triangle_mesh
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> mesh = triangle_mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    >>> round(float(signed_volumes(mesh, mesh.vertices.T)[0, 1, 2]), 12)
    0.166666666667
    """
    count = len(functions)
    integrals = np.zeros((count, count, count))
    for start in range(0, surface.n_faces, _BLOCK):
        first, second, third = (functions[:, v] for v in surface.faces[start : start + _BLOCK].T)
        means, one, two = (first + second + third) / 6.0, second - first, (third - first).T
        for mean, integral in zip(means, integrals, strict=True):
            areas = (one * mean) @ two
            integral += areas - areas.T
    volumes: FloatArray = integrals + integrals.transpose(1, 2, 0) + integrals.transpose(2, 0, 1)
    return volumes / 3.0
