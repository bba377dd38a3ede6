"""Geodesic distances along a mesh, section 3.2: four methods, one interface.

``python -m bench.geodesics`` measures them; on bodies of 5,000 vertices, about:

==================  ===========  ====================================================
method              mean error   what it does
==================  ===========  ====================================================
``graph``           1.3 %        shortest paths over straight segments; never too short
``fast_marching``   0.2 %        circular waves from edge to vertex, twice the time
``heat``            1.8 %        two linear systems, factored once; smooth
``exact``           none         windows of straight lines; fifty times the time
==================  ===========  ====================================================
"""

from typing import Literal, TypeAlias, get_args

from solver.errors import OptionError
from solver.mesh import TriangleMesh
from solver.shape.geodesics.exact import ExactGeodesics
from solver.shape.geodesics.fast_marching import FastMarching
from solver.shape.geodesics.graph import GeodesicGraph, segments
from solver.shape.geodesics.heat import HeatMethod
from solver.shape.geodesics.interface import Geodesics
from solver.shape.geodesics.intrinsic import IntrinsicTriangulation, intrinsic_triangulation

GeodesicMethod: TypeAlias = Literal["graph", "fast_marching", "heat", "exact"]
GEODESIC_METHODS: tuple[GeodesicMethod, ...] = get_args(GeodesicMethod)
"""Names of the methods."""

DEFAULT_GEODESIC_METHOD: GeodesicMethod = "fast_marching"

__all__ = [
    "DEFAULT_GEODESIC_METHOD",
    "GEODESIC_METHODS",
    "ExactGeodesics",
    "FastMarching",
    "GeodesicGraph",
    "GeodesicMethod",
    "Geodesics",
    "HeatMethod",
    "IntrinsicTriangulation",
    "geodesics",
    "intrinsic_triangulation",
    "segments",
]


def geodesics(mesh: TriangleMesh, method: str = DEFAULT_GEODESIC_METHOD) -> Geodesics:
    """Prepare a mesh for geodesic distances.

    Parameters
    ----------
    mesh
        Any mesh.
    method
        One of `GEODESIC_METHODS`.

    Raises
    ------
    OptionError
        There is no such method; the option is ``geodesic_method``.
    MeshError
        The mesh defies the method.
    """
    match method:
        case "graph":
            return GeodesicGraph(mesh)
        case "fast_marching":
            return FastMarching(mesh)
        case "heat":
            return HeatMethod(mesh)
        case "exact":
            return ExactGeodesics(mesh)
    raise OptionError("geodesic_method", f"{method!r} is none of {', '.join(GEODESIC_METHODS)}")
