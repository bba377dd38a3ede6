"""Gaussian curvature as a descriptor, Table 1."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import OptionError
from solver.mesh import TriangleMesh
from solver.shape.laplacian import DefiniteFactor, laplacian

_STEPS = 4
"""Implicit steps of the heat flow: enough for a kernel without a spike at its centre."""

_EVEN = 1e3
"""Scale, relative to √area, from which on the flow has evened out everything."""


def gaussian_curvature(
    mesh: TriangleMesh, scale: float, vertices: IntArray | None = None
) -> FloatArray:
    """Gaussian curvature, averaged over a neighbourhood.

    The curvature measure of a vertex is its angle defect, the area that belongs to it the mixed
    area of Meyer, Desbrun, Schröder and Barr (2003). Both are spread over the surface by the same
    heat flow, and the descriptor is the quotient of the two. At vertices of borders and of
    non-manifold edges the defect is the turning of the border (geodesic curvature) or of nothing
    in particular, so neither their defect nor their area is counted; the average over the
    neighbourhood reaches them from inside. Where nothing reaches, the curvature is 0.

    Parameters
    ----------
    mesh
        Any mesh.
    scale
        Root mean square distance over which is averaged, √(4t) of a heat flow of time t, in the
        mesh's unit of length; 0 for none.
    vertices
        (S,) where it is wanted; by default at all V vertices.

    Returns
    -------
    (S, 1) float64, in 1/length²: without unit, and with mean 2πχ on a closed surface, if the
    area is 1.

    Raises
    ------
    MeshError
        The mesh defies intrinsic triangulation.
    OptionError
        The scale is negative.
    """
    if not 0.0 <= scale < np.inf:
        raise OptionError("scale", "it must be finite and not negative")
    inner = inner_vertices(mesh)
    areas = mixed_areas(mesh)
    measures: FloatArray = np.where(inner, np.stack([angle_defects(mesh), areas]), 0.0)
    scale = min(scale, _EVEN * float(np.sqrt(mesh.area)))
    if scale > 0.0:
        measures = _spread(mesh, measures, areas, 0.25 * scale**2)
    curvature = np.zeros(mesh.n_vertices)
    known = measures[1] > 1e-12 * areas
    np.divide(measures[0], measures[1], out=curvature, where=known)
    return (curvature if vertices is None else curvature[vertices])[:, None]


def angle_defects(mesh: TriangleMesh) -> FloatArray:
    """Angle defects: the integral of curvature that is concentrated in each vertex.

    2π less the sum of the angles at an inner vertex, π less that sum at a border. In general it is
    (2 - E_v + F_v) π less that sum, E_v and F_v being the numbers of edges and of faces at the
    vertex, which makes Gauss and Bonnet's theorem true for any mesh, manifold or not: the sum is
    2π (V - E + F).

    Parameters
    ----------
    mesh
        Any mesh.

    Returns
    -------
    (V,) float64, in radians.
    """
    count = mesh.n_vertices
    n_edges = np.bincount(mesh.edges.ravel(), minlength=count)
    n_faces = np.bincount(mesh.faces.ravel(), minlength=count)
    angles = np.bincount(mesh.faces.ravel(), weights=_corner_angles(mesh).ravel(), minlength=count)
    defects: FloatArray = (np.pi * (2 - n_edges + n_faces) - angles).astype(np.float64)
    return defects


def inner_vertices(mesh: TriangleMesh) -> BoolArray:
    """Whether the surface around a vertex is a disc with the vertex inside.

    Parameters
    ----------
    mesh
        Any mesh.

    Returns
    -------
    (V,) bool, false at borders, non-manifold edges, and vertices where several fans meet.
    """
    sides = np.sort(mesh.faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    _, side, n_faces = np.unique(
        sides[:, 0] * mesh.n_vertices + sides[:, 1], return_inverse=True, return_counts=True
    )
    inner = np.ones(mesh.n_vertices, dtype=np.bool_)
    inner[sides[n_faces[side] != 2]] = False
    inner[_fans(mesh, side.reshape(-1)) != 1] = False
    return inner


def mixed_areas(mesh: TriangleMesh) -> FloatArray:
    """Area that belongs to each vertex: its Voronoi region, where triangles are not obtuse.

    Of an obtuse triangle, half belongs to the obtuse corner and a quarter to each of the others
    (Meyer et al., section 3.3).

    Parameters
    ----------
    mesh
        Any mesh.

    Returns
    -------
    (V,) float64, positive; the sum is the area of the surface.
    """
    corners = mesh.vertices[mesh.faces]
    squares = ((corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]) ** 2).sum(axis=2)  # opposite sides
    twice = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )[:, None]
    cosines = squares.sum(axis=1, keepdims=True) - 2.0 * squares  # times twice the adjacent sides
    voronoi = (cosines * squares) / (8.0 * twice)
    share = 0.5 * (voronoi.sum(axis=1, keepdims=True) - voronoi)
    obtuse = cosines < 0.0
    quarter = np.where(obtuse, 0.25, 0.125) * twice
    pieces = np.where(obtuse.any(axis=1, keepdims=True), quarter, share)
    areas: FloatArray = np.bincount(
        mesh.faces.ravel(), weights=pieces.ravel(), minlength=mesh.n_vertices
    ).astype(np.float64)
    return areas


def _corner_angles(mesh: TriangleMesh) -> FloatArray:
    """(F, 3) angles of the faces, in radians; they sum to π."""
    corners = mesh.vertices[mesh.faces]
    forward = corners[:, [1, 2, 0]] - corners
    backward = corners[:, [2, 0, 1]] - corners
    twice = np.linalg.norm(np.cross(forward, backward), axis=2)
    angles: FloatArray = np.arctan2(twice, np.einsum("fci,fci->fc", forward, backward))
    return angles


def _fans(mesh: TriangleMesh, side: IntArray) -> IntArray:
    """Number of fans of faces at each vertex, a fan being joined by edges at the vertex.

    `side` (3F,) is the edge opposite each corner of the faces, in their order.
    """
    vertex, corner = mesh.faces.ravel(), np.arange(mesh.faces.size)
    following, preceding = (
        corner.reshape(-1, 3)[:, roll].ravel() for roll in ([1, 2, 0], [2, 0, 1])
    )
    # Corners at one vertex on either side of an edge at it are those that share (edge, vertex).
    keys = np.concatenate([side[following], side[preceding]]) * mesh.n_vertices + np.tile(vertex, 2)
    order = np.argsort(keys, kind="stable")
    same = keys[order][1:] == keys[order][:-1]
    i, j = (np.tile(corner, 2)[order][part][same] for part in (slice(1, None), slice(None, -1)))
    joined = sp.coo_array((np.ones(len(i)), (i, j)), shape=(len(corner),) * 2)
    fan_of_corner = connected_components(joined, directed=False)[1]
    vertex_of_fan = np.empty(fan_of_corner.max() + 1, dtype=np.int64)
    vertex_of_fan[fan_of_corner] = vertex
    return np.bincount(vertex_of_fan, minlength=mesh.n_vertices).astype(np.int64)


def _spread(mesh: TriangleMesh, measures: FloatArray, areas: FloatArray, time: float) -> FloatArray:
    """Let heat flow for some time: (n, V) measures, integrated over the vertices' areas."""
    stiffness, _ = laplacian(mesh)
    step = DefiniteFactor(sp.csc_array(sp.diags_array(areas) + (time / _STEPS) * stiffness))
    for _ in range(_STEPS):
        measures = areas * step.solve(measures.T).T
    return measures
