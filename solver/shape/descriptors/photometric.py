"""Photometric descriptor, section 3.8."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_areas
from solver.shape.descriptors.geodesic_disc import disc_weights, distances_from
from solver.shape.metrics import Metric


def photometric(
    mesh: TriangleMesh, metric: Metric, radius: float, vertices: IntArray
) -> FloatArray:
    """Mean colour of the surface around a point, sections 3.8 and 6.3.

    The mean of the colour, interpolated linearly, over the geodesic disc of the given radius, or
    the colour of the vertex if the radius is 0. Red, green and blue are in [0, 1] and divided by
    √3.

    Parameters
    ----------
    mesh
        A mesh with colours.
    metric
        Geodesic metric of `mesh`.
    radius
        r >= 0, in the mesh's unit of length.
    vertices
        (S,) int64 vertices: as many shortest path searches, unless the radius is 0.

    Returns
    -------
    (S, 3) float64, without unit. With radius 0 it depends on the colours alone; otherwise it
    changes with topology, and with scale unless the radius scales too: the footnotes of Table 1.
    """
    assert mesh.colors is not None
    colors = mesh.colors[vertices]
    if radius > 0.0:
        areas = triangle_areas(mesh.vertices, mesh.faces)
        for rows, distances in distances_from(metric, vertices):
            weights = disc_weights(distances, mesh.faces, areas, radius)
            disc = weights.sum(axis=1, keepdims=True)
            # The area of tiny discs underflows to 0; their mean is the colour of the vertex.
            np.divide(weights @ mesh.colors, disc, out=colors[rows], where=disc > 0.0)
    result: FloatArray = colors / np.sqrt(3.0)
    return result
