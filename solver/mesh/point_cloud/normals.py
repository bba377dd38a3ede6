"""Normals of a point cloud: fitted planes, whose signs are those of what is seen from outside.

Planes by principal components of neighbourhoods, as Hoppe, DeRose, Duchamp, McDonald and Stuetzle,
"Surface reconstruction from unorganized points", SIGGRAPH 1992, fit them. They carry signs from
point to point along a minimum spanning tree; but in thin parts, such as hands, planes mix both
sides, and all beyond comes out inside out. Here each point is looked at from many directions: it is
outside where it is seen. An open sheet is seen from both sides; where the two disagree, signs are
those that are carried from point to point.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from solver.arrays import BoolArray, FloatArray, IntArray

_DIRECTIONS = 100
"""Directions from which points are looked at."""

_PIXEL = 2.0
"""Width of what hides what is behind it, in mean distances to near points: such pixels have a point
each, nearly all of them. Points as far behind the first one of their pixel are seen, too, as they
may be on the same sloping surface."""

_MOST_PIXELS = 64
"""Pixels for each point at most; evenly sampled bodies take about one."""

_SURE = 0.1
"""Mean over all directions of the cosine to those from which a point is seen, from which on its
sign is sure; 0.25 where it is seen from everywhere outside."""

_LINKS = 8
"""Nearest points that signs are carried to."""

_POWER = 4
"""Power of the cosine between normals that signs are carried by."""

_FIDELITY = 1e-6
"""Weight of where a point is seen from, over that of a neighbour whose normal is the same: so small
that one sign is carried over the whole of a surface."""

_LEAST = 1e-300


def fitted_planes(
    points: FloatArray, neighbours: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Planes of least squared distance to the points' neighbourhoods.

    Parameters
    ----------
    points
        (V, 3).
    neighbours
        (V, k) of each point, without itself.

    Returns
    -------
    centres : (V, 3) means of the neighbourhoods, the points included.
    normals : (V, 3) unit normals, of any sign.
    thickness : (V,) variance across the plane, over the lesser one along it; 0 where all are 0.
    """
    around = np.concatenate([points[:, None], points[neighbours]], axis=1)
    centres = around.mean(axis=1)
    around -= centres[:, None]
    moments = np.einsum("vki,vkj->vij", around, around)
    variances, axes = np.linalg.eigh(moments)
    thickness = np.abs(variances[:, 0]) / np.maximum(variances[:, 1], _LEAST)
    return centres, axes[:, :, 0], thickness


def outward_normals(
    points: FloatArray, normals: FloatArray, neighbours: IntArray, spacing: float
) -> FloatArray:
    """Give normals consistent signs, outwards, and lengths for how sure these are.

    Parameters
    ----------
    points, normals
        (V, 3) each; unit normals.
    neighbours
        (V, k) nearest points of each, the nearest first.
    spacing
        Mean distance to near points.

    Returns
    -------
    (V, 3) float64, of lengths from 0 to 1.
    """
    seen = _seen_from(points, normals, spacing)
    alike = np.where(_carried(seen, normals, neighbours[:, :_LINKS]) < 0.0, -1.0, 1.0)
    closed = max(float(seen @ alike) / max(float(np.abs(seen).sum()), _LEAST), 0.0)
    found: FloatArray = normals * (closed * seen + (1.0 - closed) * alike)[:, None]
    return found


def _carried(seen: FloatArray, normals: FloatArray, neighbours: IntArray) -> FloatArray:
    """(V,) signs, carried from point to point where normals are alike up to their sign."""
    count = len(normals)
    rows, columns = np.repeat(np.arange(count), neighbours.shape[1]), neighbours.ravel()
    cosine = np.einsum("ij,ij->i", normals[rows], normals[columns])
    links = sp.csr_array((np.sign(cosine) * cosine**_POWER, (rows, columns)), shape=(count, count))
    links = links + links.T
    total = np.asarray(abs(links).sum(axis=1)).ravel() + _FIDELITY
    matrix = sp.csc_array(sp.diags_array(total) - links)
    factor = splu(
        matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(factor.solve(_FIDELITY * seen))


def _seen_from(points: FloatArray, normals: FloatArray, spacing: float) -> FloatArray:
    """(V,) whether points are seen from the side of their normals, 1, or the other, -1, or both."""
    total = np.zeros(len(points))
    for direction in _on_sphere(_DIRECTIONS):
        seen = _seen(points, direction, _PIXEL * spacing)
        total[seen] += normals[seen] @ direction
    found: FloatArray = np.clip(total / (_SURE * _DIRECTIONS), -1.0, 1.0)
    return found


def _on_sphere(count: int) -> FloatArray:
    """(n, 3) directions, spread evenly along a spiral."""
    number = np.arange(count) + 0.5
    height = 1.0 - 2.0 * number / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * number
    radius = np.sqrt(1.0 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def _seen(points: FloatArray, direction: FloatArray, width: float) -> BoolArray:
    """(V,) which points are seen from far away in a direction, in pixels of a width."""
    rows, columns = (points @ one for one in np.linalg.svd(direction[None])[2][1:])
    rows, columns = rows - rows.min(), columns - columns.min()
    # Where few points are far from all others, pixels are larger, so that they are not too many.
    high, wide, most = float(rows.max()), float(columns.max()), _MOST_PIXELS * len(points)
    width = max(width, high / most, wide / most, float(np.sqrt(high * wide / most)))
    place = np.stack([rows, columns]) / width
    row, column = place.astype(np.int64)
    pixel = row * (column.max() + 1) + column
    towards = points @ direction
    first = np.full(pixel.max() + 1, -np.inf)
    np.maximum.at(first, pixel, towards)
    seen: BoolArray = towards > first[pixel] - width
    return seen
