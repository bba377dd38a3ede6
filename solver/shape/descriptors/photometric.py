"""Photometric descriptors, section 3.8."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError, OptionError
from solver.mesh import TriangleMesh, triangle_areas
from solver.shape.descriptors.geodesic_disc import disc_weights, distances_from
from solver.shape.metrics import Metric


def photometric(
    mesh: TriangleMesh, metric: Metric, radius: float, vertices: IntArray | None = None
) -> FloatArray:
    """Mean colour of the surface around a point, sections 3.8 and 6.3.

    The mean of the colour, linear between vertices, over the geodesic disc of the given radius;
    the colour of the vertex itself if the radius is 0. Red, green and blue are in 0..1 and divided
    by √3.

    Parameters
    ----------
    mesh
        A mesh with colours.
    metric
        Geodesic metric of `mesh`.
    radius
        r >= 0, in the mesh's unit of length.
    vertices
        (S,) where it is wanted; by default at all V vertices, which takes V shortest path
        searches unless the radius is 0.

    Returns
    -------
    (S, 3) float64, without unit. With radius 0 it changes with nothing but the colours
    themselves; otherwise with topology, and with the scale unless the radius is scaled along:
    the footnotes of Table 1.

    Raises
    ------
    MeshError
        The mesh has no colours.
    OptionError
        The radius is negative.
    """
    if mesh.colors is None:
        raise MeshError(
            "the mesh has no vertex colours, which the photometric descriptor is made of; "
            "choose another descriptor, or upload the shape in a format that carries them"
        )
    if not 0.0 <= radius < np.inf:
        raise OptionError("radius", "it must be finite and not negative")
    if vertices is None:
        vertices = np.arange(mesh.n_vertices)
    colors = mesh.colors[vertices]
    if radius > 0.0:
        areas = triangle_areas(mesh.vertices, mesh.faces)
        for rows, distances in distances_from(metric, vertices):
            weights = disc_weights(distances, mesh.faces, areas, radius)
            disc = weights.sum(axis=1, keepdims=True)
            # The area of the smallest discs vanishes in floating point; their mean is the colour.
            np.divide(weights @ mesh.colors, disc, out=colors[rows], where=disc > 0.0)
    result: FloatArray = colors / np.sqrt(3.0)
    return result
