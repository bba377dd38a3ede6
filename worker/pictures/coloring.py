"""Colours of surfaces and of matched points: corresponding vertices have the same colour."""

import numpy as np
from matplotlib.colors import hsv_to_rgb

from broker.contracts import InverseCorrespondence
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh

_PALEST = 0.35
"""Least value of a channel, so that points and lines stand out from the surface."""

_POINT_VALUE = 0.84
"""Value of the colours of points in HSV, as on the page (service/page/static/colors.js)."""

_THINNEST = 1e-6
"""Least extent that counts, as a share of the other: rounding errors have no direction."""


def point_colors(places: FloatArray) -> FloatArray:
    """(K, 3) hue by direction from the middle, paler near it: neighbours have similar colours.

    Offsets are in units of half the extents, so that all hues are used on a tall or broad shape.

    Parameters
    ----------
    places
        (K, 2) or (K, 3), to the right and up; the depth does not count.
    """
    if not len(places):
        return np.zeros((0, 3))
    flat = places[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    half = 0.5 * (high - low)
    half = np.maximum(half, max(_THINNEST * float(half.max()), 1e-300))
    offsets = (flat - 0.5 * (low + high)) / half
    hue = (np.arctan2(offsets[:, 1], offsets[:, 0]) / (2.0 * np.pi)) % 1.0
    reach = np.linalg.norm(offsets, axis=1)
    saturation = 0.55 + 0.40 * reach / max(float(reach.max()), 1e-300)
    value = np.full_like(hue, _POINT_VALUE)
    return np.asarray(hsv_to_rgb(np.stack([hue, saturation, value], axis=1)))


def colors_by_place(vertices: FloatArray) -> FloatArray:
    """(V, 3) colours by position: red, green and blue increase along x, y and z.

    Parameters
    ----------
    vertices
        (V, 3) in the coordinates of the paper.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    shares = (vertices - low) / np.maximum(high - low, 1e-300)
    colors: FloatArray = _PALEST + (1.0 - _PALEST) * shares
    return colors


def transferred_colors(
    colors: FloatArray, source: TriangleMesh, target: TriangleMesh, found: InverseCorrespondence
) -> FloatArray:
    """(W, 3) colours of the target: each vertex has the colour of its point on the source.

    Parameters
    ----------
    colors
        (V, 3) of the source's vertices.
    source, target
        The meshes X and Y.
    found
        The map of the vertices of Y. Vertices that are not in it are white.
    """
    corners = source.vertices_of(np.array(found.faces, dtype=np.int64).ravel()).reshape(-1, 3)
    vertices = target.vertices_of(np.array(found.target, dtype=np.int64))
    transferred = np.ones((target.n_vertices, 3))
    transferred[vertices] = np.einsum("kc,kcd->kd", np.array(found.barycentric), colors[corners])
    return transferred
