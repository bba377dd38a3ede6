"""Local histograms of geodesic distances as a descriptor, section 3.5.

Raviv, Bronstein, Bronstein and Kimmel, "Symmetries of non-rigid shapes", NORDIA 2007.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_areas
from solver.shape.descriptors.geodesic_disc import annulus_areas, distances_from
from solver.shape.metrics import Metric


def geodesic_histogram(
    mesh: TriangleMesh, metric: Metric, radius: float, bins: int, vertices: IntArray
) -> FloatArray:
    """Histogram of the geodesic distances from a point to the surface around it, section 3.5.

    Bin j of B at vertex x is the area of the annulus {z : (j-1) r/B <= d(x, z) < j r/B}, divided
    by that of the same annulus in the plane and by √B. Times √B, every bin of a point with a flat
    neighbourhood is 1; positive curvature or a boundary decreases it, negative curvature increases
    it. Annuli are clipped exactly, so that bins are continuous in the point and in the radius.

    Parameters
    ----------
    mesh
        Any mesh.
    metric
        Geodesic metric of `mesh`.
    radius
        r > 0, in the mesh's unit of length.
    bins
        B, at least 1.
    vertices
        (S,) int64 vertices: as many shortest path searches.

    Returns
    -------
    (S, B) float64, without unit. It is invariant to scale only if the radius scales too, and
    changes with topology as all geodesic distances do: Table 1.
    """
    areas = triangle_areas(mesh.vertices, mesh.faces)
    histogram = np.empty((len(vertices), bins))
    for rows, distances in distances_from(metric, vertices):
        histogram[rows] = annulus_areas(distances, mesh.faces, areas, radius, bins)
    flat = np.pi * (radius / bins) ** 2 * (2.0 * np.arange(bins) + 1.0)
    result: FloatArray = histogram / (flat * np.sqrt(bins))
    return result
