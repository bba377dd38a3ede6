"""Conformal factors (Ben-Chen and Gotsman, 3DOR 2008)."""

import numpy as np
import scipy.sparse as sp

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.shape.descriptors.gaussian_curvature import angle_defects, inner_vertices, mixed_areas
from solver.shape.laplacian import DefiniteFactor, laplacian


def conformal_factor(mesh: TriangleMesh, vertices: IntArray | None = None) -> FloatArray:
    """Logarithm of the factor by which lengths have to change for the curvature to be even.

    Solves Δφ = K_T - K, with Δ the positive semi-definite Laplace-Beltrami operator, K the
    curvature measure (angle defects) and K_T the same total curvature spread evenly over the
    area. The metric e^{2φ} times the surface's own then has the curvature K_T, to first order in
    φ; exactly, where K_T is 0. φ is small at tips, which would have to shrink, and large in what
    lies deep between them.

    What is a border in the mesh remains one of the same turning: only inner vertices have
    curvature, and φ has natural (Neumann) conditions. Every component is treated by itself.

    Parameters
    ----------
    mesh
        Any mesh.
    vertices
        (S,) where it is wanted; by default at all V vertices.

    Returns
    -------
    (S, 1) float64, without unit. The equation leaves a constant open, in every component; here
    the mean over its area is 0. So φ does not change with the scale of the shape. (Table 1 says
    that it does, as it is when the constant is fixed by the size of what is mapped to.)

    Raises
    ------
    MeshError
        The mesh defies intrinsic triangulation.
    """
    stiffness, _ = laplacian(mesh)
    areas, inner = mixed_areas(mesh), inner_vertices(mesh)
    component = mesh.component_of_vertex
    curvature = np.where(inner, angle_defects(mesh), 0.0)
    inner_area = np.where(inner, areas, 0.0)
    total, extent = (np.bincount(component, weights=part) for part in (curvature, inner_area))
    density = np.divide(total, extent, out=np.zeros_like(total), where=extent > 0.0)
    factor = _solved(stiffness, density[component] * inner_area - curvature, component)
    mean = np.bincount(component, weights=areas * factor) / np.bincount(component, weights=areas)
    factor -= mean[component]
    return (factor if vertices is None else factor[vertices])[:, None]


def _solved(stiffness: sp.csc_array, right: FloatArray, component: IntArray) -> FloatArray:
    """A solution of the singular system: the one that is 0 at one vertex of every component."""
    free = np.ones(len(right), dtype=np.bool_)
    free[np.unique(component, return_index=True)[1]] = False
    solution = np.zeros(len(right))
    if free.any():
        factor = DefiniteFactor(stiffness[free][:, free])
        solution[free] = factor.solve(right[free])
    return solution
