"""Gaussian curvature as a descriptor, Table 1."""

import numpy as np
import scipy.sparse as sp

from solver.arrays import BoolArray, FloatArray
from solver.mesh import TriangleMesh, non_manifold_vertices, triangle_areas
from solver.shape.laplacian import definite_factor, laplacian

_STEPS = 4
"""Implicit Euler steps of the heat flow: enough for a kernel without a spike at its centre."""

_MOST_SCALE = 1e3
"""Greatest scale, relative to √area; the curvature is constant to working precision before."""

_LEAST_AREA = 1e-12
"""Share of a vertex's area that the heat flow must bring from inner vertices for a known value."""


def gaussian_curvature(mesh: TriangleMesh, scale: float) -> FloatArray:
    """Gaussian curvature, averaged over a neighbourhood.

    The curvature measure of a vertex is its angle defect, and its area the mixed area (Meyer,
    Desbrun, Schröder and Barr, "Discrete differential-geometry operators for triangulated
    2-manifolds", VisMath 2002). Both are spread over the surface by the same heat flow,
    and the descriptor is their quotient. At boundaries the defect is geodesic curvature, and at
    non-manifold edges it has no meaning, so neither defect nor area of their vertices counts; the
    average over the neighbourhood reaches them from inside. Where nothing reaches, it is 0.

    Parameters
    ----------
    mesh
        Any mesh.
    scale
        Root mean square radius of the neighbourhood, √(4t) for a heat flow of time t, in the
        mesh's unit of length; 0 for no averaging.

    Returns
    -------
    (V, 1) float64, in 1/length²; its mean is 2πχ on a closed surface of unit area.

    Raises
    ------
    MeshError
        The Laplacian of the mesh is singular to working precision, or not finite.
    """
    inner = inner_vertices(mesh)
    areas = mixed_areas(mesh)
    measures: FloatArray = np.where(inner, np.stack([angle_defects(mesh), areas]), 0.0)
    scale = min(scale, _MOST_SCALE * float(np.sqrt(mesh.area)))
    if scale > 0.0:
        measures = _spread(mesh, measures, areas, 0.25 * scale**2)
    curvature = np.zeros(mesh.n_vertices)
    known = measures[1] > _LEAST_AREA * areas
    np.divide(measures[0], measures[1], out=curvature, where=known)
    return curvature[:, None]


def angle_defects(mesh: TriangleMesh) -> FloatArray:
    """Angle defects: the integral of Gaussian curvature concentrated in each vertex.

    2π minus the sum of the angles at an inner vertex, π minus that sum at a boundary. In general it
    is (2 - E_v + F_v) π minus that sum, E_v and F_v being the numbers of edges and of faces at the
    vertex, with which the Gauss-Bonnet theorem holds for any mesh, manifold or not: the sum is
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
    """Mask of the vertices with a neighbourhood that is a disc.

    Parameters
    ----------
    mesh
        Any mesh.

    Returns
    -------
    (V,) bool, false at boundaries, non-manifold edges, and vertices where several fans meet.
    """
    edges = mesh.face_edges
    inner = np.ones(mesh.n_vertices, dtype=np.bool_)
    inner[edges.ends[edges.counts != 2]] = False
    inner[non_manifold_vertices(mesh.faces, edges)] = False
    return inner


def mixed_areas(mesh: TriangleMesh) -> FloatArray:
    """Mixed area of each vertex: its Voronoi region in triangles that are not obtuse.

    Half of an obtuse triangle belongs to the obtuse corner, a quarter to each of the others (Meyer
    et al. 2002, section 3.3).

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
    twice = 2.0 * triangle_areas(mesh.vertices, mesh.faces)[:, None]
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


def _spread(mesh: TriangleMesh, measures: FloatArray, areas: FloatArray, time: float) -> FloatArray:
    """(n, V) measures, integrals over the vertices' areas, after a heat flow of some time."""
    stiffness, _ = laplacian(mesh)
    step = definite_factor(sp.csc_array(sp.diags_array(areas) + (time / _STEPS) * stiffness))
    for _ in range(_STEPS):
        measures = areas * step.solve(measures.T).T
    return measures
