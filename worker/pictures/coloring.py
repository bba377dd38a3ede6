"""Colours of surfaces and of matched points: corresponding vertices have the same colour."""

from typing import Final

import numpy as np
from matplotlib.colors import hsv_to_rgb

from broker.contracts import InverseCorrespondence
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh

_PALEST = 0.35
"""Least value of a channel, so that points and lines stand out from the surface."""

UNMAPPED: Final = 200.0 / 255.0
"""Grey level of vertices that a dense map leaves out, as on the page."""

_POINT_VALUE = 0.84
"""Value of the colours of points in HSV, as on the page (service/page/static/colors.js)."""

PALE: Final = 0.5
"""Share of the points' colours in the surface's, likewise; the rest is light grey."""

LIGHT: Final = 235.0 / 255.0
"""Level of that light grey."""

_THINNEST = 1e-6
"""Least extent that counts, as a share of the other: rounding errors have no direction."""


def point_colors(places: FloatArray, around: FloatArray | None = None) -> FloatArray:
    """(K, 3) hue by direction from the middle, paler near it: neighbours have similar colours.

    Offsets are in units of half the extents, so that all hues are used on a tall or broad shape.

    Parameters
    ----------
    places
        (K, 2) or (K, 3), to the right and up; the depth does not count.
    around
        Points whose middle and extents count, if not those of `places`.
    """
    known = (places if around is None else around)[:, :2]
    if not len(known):
        return np.full((len(places), 3), UNMAPPED)
    low, high = known.min(axis=0), known.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = np.maximum(half, max(_THINNEST * float(half.max()), 1e-300))
    offsets = (places[:, :2] - middle) / half
    hue = (np.arctan2(offsets[:, 1], offsets[:, 0]) / (2.0 * np.pi)) % 1.0
    farthest = float(np.linalg.norm((known - middle) / half, axis=1).max())
    reach = np.linalg.norm(offsets, axis=1) / max(farthest, 1e-300)
    saturation = 0.55 + 0.40 * np.minimum(reach, 1.0)
    value = np.full_like(hue, _POINT_VALUE)
    return np.asarray(hsv_to_rgb(np.stack([hue, saturation, value], axis=1)))


def surface_colors(vertices: FloatArray, points: FloatArray) -> FloatArray:
    """(V, 3) colours of a surface: each place has the colour that a point has there, paler.

    Parameters
    ----------
    vertices, points
        (V, 3) and (K, 3), of the surface and matched points, in the coordinates of the paper.
    """
    colors: FloatArray = PALE * point_colors(vertices, points) + (1.0 - PALE) * LIGHT
    return colors


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
        The map of the vertices of Y. Vertices that are not in it are grey.
    """
    corners = source.vertices_of(np.array(found.faces, dtype=np.int64).ravel()).reshape(-1, 3)
    vertices = target.vertices_of(np.array(found.target, dtype=np.int64))
    transferred = np.full((target.n_vertices, 3), UNMAPPED)
    transferred[vertices] = np.einsum("kc,kcd->kd", np.array(found.barycentric), colors[corners])
    return transferred
