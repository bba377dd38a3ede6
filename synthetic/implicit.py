"""Implicit surfaces of bodies: smooth unions of rounded cones, and marching cubes."""

import math
from typing import NamedTuple

import numpy as np
from skimage.measure import marching_cubes

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from synthetic.skeleton import Cones


class Skin(NamedTuple):
    """Values at p points of the function whose zero level set is the skin.

    Attributes
    ----------
    value
        (p,) float64, about the distance from the skin, negative inside.
    gradient
        (p, 3) float64, of length near 1 close to the skin.
    thickness
        (p,) float64, mean radius of the cones nearby, in metres.
    """

    value: FloatArray
    gradient: FloatArray
    thickness: FloatArray


def body(cones: Cones, blend: float, points: FloatArray) -> Skin:
    """Smooth union of cones, ``-b log(sum_i exp(-d_i / b))``, at points.

    Parameters
    ----------
    cones
        n cones.
    blend
        b, in metres.
    points
        (p, 3) float64.

    Returns
    -------
    skin
        Value, gradient and thickness.
    """
    arrays = cones.start, cones.end, cones.start_radius, cones.end_radius
    distances, gradients, thickness = _union(*arrays, blend, points)
    return Skin(distances, gradients, thickness)


def cone_distances(cones: Cones, points: FloatArray) -> FloatArray:
    """Distance of points from each cone, negative inside.

    Parameters
    ----------
    cones
        n cones.
    points
        (p, 3) float64.

    Returns
    -------
    distances
        (p, n) float64. Measured to the ball whose centre is the nearest point of the axis, which
        differs from the Euclidean distance by second order in the taper.
    """
    distances = np.empty((len(points), len(cones.start)))
    for i in range(len(cones.start)):
        axis = cones.end[i] - cones.start[i]
        from_start = points - cones.start[i]
        along = np.clip(from_start @ axis / max(float(axis @ axis), 1e-30), 0.0, 1.0)
        across = np.linalg.norm(from_start - along[:, None] * axis, axis=1)
        taper = cones.end_radius[i] - cones.start_radius[i]
        distances[:, i] = across - cones.start_radius[i] - along * taper
    return distances


@kernel
def _union(
    start: FloatArray,
    end: FloatArray,
    start_radius: FloatArray,
    end_radius: FloatArray,
    blend: float,
    points: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    n, p = len(start), len(points)
    value, gradient, thickness = np.empty(p), np.empty((p, 3)), np.empty(p)
    distance, along = np.empty(n), np.empty(n)
    axis, taper, inverse = end - start, end_radius - start_radius, np.empty(n)
    for i in range(n):
        square = axis[i, 0] ** 2 + axis[i, 1] ** 2 + axis[i, 2] ** 2
        inverse[i] = 1.0 / max(square, 1e-30)
    for k in range(p):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        for i in range(n):
            a, b, c = x - start[i, 0], y - start[i, 1], z - start[i, 2]
            dot = a * axis[i, 0] + b * axis[i, 1] + c * axis[i, 2]
            t = min(max(dot * inverse[i], 0.0), 1.0)
            a, b, c = a - t * axis[i, 0], b - t * axis[i, 1], c - t * axis[i, 2]
            along[i] = t
            distance[i] = math.sqrt(a * a + b * b + c * c) - start_radius[i] - t * taper[i]
        nearest = distance.min()
        total = radius = 0.0
        gradient[k] = 0.0
        for i in range(n):
            if distance[i] > nearest + 20.0 * blend:
                continue
            share, t = math.exp((nearest - distance[i]) / blend), along[i]
            across = max(distance[i] + start_radius[i] + t * taper[i], 1e-12)
            slope = taper[i] * inverse[i] if 0.0 < t < 1.0 else 0.0
            for d in range(3):
                offset = points[k, d] - start[i, d] - t * axis[i, d]
                gradient[k, d] += share * (offset / across - slope * axis[i, d])
            total += share
            radius += share * (start_radius[i] + t * taper[i])
        gradient[k] /= total
        thickness[k] = radius / total
        value[k] = nearest - blend * math.log(total)
    return value, gradient, thickness


def marching_cubes_surface(
    cones: Cones, blend: float, spacing: float, offset: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Triangulate the skin on a regular grid.

    Parameters
    ----------
    cones
        n cones.
    blend
        Width of the smooth union, in metres.
    spacing
        Edge of a grid cell, in metres; parts thinner than about two cells are lost.
    offset
        (3,) float64 in 0..1: shift of the grid, in cells.

    Returns
    -------
    vertices, faces
        (V, 3) float64 and (F, 3) int64, oriented outwards.
    """
    margin = 6.0 * blend + 2.0 * spacing
    radius = np.maximum(cones.start_radius, cones.end_radius)[:, None] + margin
    low = np.minimum(cones.start, cones.end) - radius
    high = np.maximum(cones.start, cones.end) + radius
    origin = low.min(axis=0) - spacing * (1.0 + offset)
    counts = np.ceil((high.max(axis=0) - origin) / spacing).astype(np.int64) + 2
    axes = [origin[d] + spacing * np.arange(counts[d]) for d in range(3)]
    # Far from every cone, the distance is 6 times the blend.
    total = np.full(tuple(counts), np.exp(-6.0))
    for i in range(len(cones.start)):
        first = np.floor((low[i] - origin) / spacing).astype(np.int64)
        last = np.ceil((high[i] - origin) / spacing).astype(np.int64) + 1
        box = tuple(slice(int(a), int(b)) for a, b in zip(first, last, strict=True))
        total[box] += np.exp(-_on_grid(cones, i, [axes[d][box[d]] for d in range(3)]) / blend)
    field = -blend * np.log(total)
    vertices, faces, _, _ = marching_cubes(field, 0.0)
    return origin + spacing * vertices.astype(np.float64), faces.astype(np.int64)


def _on_grid(cones: Cones, i: int, axes: list[FloatArray]) -> FloatArray:
    """Distances from one cone on a grid, by sums of one-dimensional terms."""
    axis = cones.end[i] - cones.start[i]
    length = max(float(axis @ axis), 1e-30)
    x, y, z = (axes[d] - cones.start[i, d] for d in range(3))
    dot = (x * axis[0])[:, None, None] + (y * axis[1])[:, None] + z * axis[2]
    square = (x * x)[:, None, None] + (y * y)[:, None] + z * z
    along = np.clip(dot / length, 0.0, 1.0)
    across = np.sqrt(np.maximum(square - 2.0 * along * dot + along * along * length, 0.0))
    taper = cones.end_radius[i] - cones.start_radius[i]
    result: FloatArray = across - cones.start_radius[i] - along * taper
    return result
