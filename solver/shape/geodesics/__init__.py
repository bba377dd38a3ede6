"""Geodesic distances along a mesh, section 3.2: three methods with one interface.

Mean errors against exact distances on generated bodies of 5,000 vertices, and times relative to
``graph``, both by ``python -m bench.geodesics``:

==================  ===========  =====  ====================================================
method              mean error   time   description
==================  ===========  =====  ====================================================
``graph``           1.3 %        1      shortest paths over straight segments; never too short
``fast_marching``   0.2 %        1.6    fast marching with circular wavefronts
``heat``            1.7 %        1.5    two sparse linear systems, factored once; smooth
==================  ===========  =====  ====================================================
"""

from typing import Literal, TypeAlias, get_args

from solver.mesh import TriangleMesh
from solver.shape.geodesics.fast_marching import FastMarching
from solver.shape.geodesics.graph import GeodesicGraph
from solver.shape.geodesics.heat import HeatMethod
from solver.shape.geodesics.interface import Geodesics

GeodesicMethod: TypeAlias = Literal["graph", "fast_marching", "heat"]
GEODESIC_METHODS: tuple[GeodesicMethod, ...] = get_args(GeodesicMethod)
"""Names of the methods."""

DEFAULT_GEODESIC_METHOD: GeodesicMethod = "fast_marching"

_METHODS: dict[str, type[GeodesicGraph | FastMarching | HeatMethod]] = {
    "graph": GeodesicGraph,
    "fast_marching": FastMarching,
    "heat": HeatMethod,
}

__all__ = [
    "DEFAULT_GEODESIC_METHOD",
    "GEODESIC_METHODS",
    "FastMarching",
    "GeodesicGraph",
    "GeodesicMethod",
    "Geodesics",
    "geodesics",
]


def geodesics(mesh: TriangleMesh, method: str = DEFAULT_GEODESIC_METHOD) -> Geodesics:
    """Prepare geodesic distances on a mesh.

    Parameters
    ----------
    mesh
        Any mesh: boundaries, non-manifold edges and several components are allowed.
    method
        One of `GEODESIC_METHODS`.

    Raises
    ------
    MeshError
        The linear systems of ``heat`` cannot be built on this mesh.

    Examples
    --------
    >>> import numpy as np
    >>> from solver.mesh import triangle_mesh
    >>> square = triangle_mesh(
    ...     np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
    ...     np.array([[0, 1, 2], [0, 2, 3]]),
    ... )
    >>> geodesics(square).distances(np.array([1])).round(3)
    array([[1.   , 0.   , 1.   , 1.414]])
    """
    return _METHODS[method](mesh)
