"""Conformal factors as a descriptor, Table 1.

Ben-Chen and Gotsman, "Characterizing shape using conformal factors", 3DOR 2008.
"""

import numpy as np
import scipy.sparse as sp

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.shape.descriptors.gaussian_curvature import angle_defects, inner_vertices, mixed_areas
from solver.shape.laplacian import definite_factor, laplacian


def conformal_factor(mesh: TriangleMesh) -> FloatArray:
    """Logarithm of the factor by which lengths have to change for constant curvature.

    Solves Δφ = K_T - K, with Δ the positive semi-definite Laplace-Beltrami operator, K the
    curvature measure (angle defects) and K_T the same total curvature spread evenly over the
    area. The surface's metric times e^{2φ} has the curvature K_T, to first order in φ, and exactly
    where K_T is 0. φ is small at extremities, which would have to shrink, and large between them.

    Only inner vertices have curvature, and φ has natural (Neumann) conditions at boundaries, whose
    geodesic curvature is kept. Connected components are independent.

    Parameters
    ----------
    mesh
        Any mesh.

    Returns
    -------
    (V, 1) float64, without unit. φ is determined up to a constant in every component, chosen such
    that its mean over the area is 0, which makes it invariant to scale. (Table 1 says otherwise,
    as is true if the constant is fixed by the size of the surface that is mapped to.)

    Raises
    ------
    MeshError
        The Laplacian of the mesh is singular to working precision, or not finite.
    """
    stiffness, _ = laplacian(mesh, linked=False)
    areas, inner = mixed_areas(mesh), inner_vertices(mesh)
    component = mesh.component_of_vertex
    curvature = np.where(inner, angle_defects(mesh), 0.0)
    inner_area = np.where(inner, areas, 0.0)
    total, extent = (np.bincount(component, weights=part) for part in (curvature, inner_area))
    density = np.divide(total, extent, out=np.zeros_like(total), where=extent > 0.0)
    factor = _solve(stiffness, density[component] * inner_area - curvature, component)
    mean = np.bincount(component, weights=areas * factor) / np.bincount(component, weights=areas)
    factor -= mean[component]
    return factor[:, None]


def _solve(stiffness: sp.csc_array, right: FloatArray, component: IntArray) -> FloatArray:
    """Solution of the singular system that is 0 at one vertex of every component."""
    free = np.ones(len(right), dtype=np.bool_)
    free[np.unique(component, return_index=True)[1]] = False
    solution = np.zeros(len(right))
    if free.any():
        factor = definite_factor(stiffness[free][:, free])
        solution[free] = factor.solve(right[free])
    return solution
