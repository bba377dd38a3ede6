"""The body as a level set: smooth union of rounded cones, and its marching-cubes surface."""

import numpy as np
from skimage.measure import marching_cubes

from solver.arrays import FloatArray, IntArray
from solver.synthetic.skeleton import Cones


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
    return np.stack([_one_cone(cones, i, points)[0] for i in range(len(cones.start))], axis=1)


def body(cones: Cones, blend: float, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Value and gradient of the function whose zero level is the skin.

    The union is smoothed as ``-b log(sum_i exp(-d_i / b))``.

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
    value
        (p,) float64, negative inside.
    gradient
        (p, 3) float64, of length near 1 close to the skin.
    """
    distances = np.empty((len(cones.start), len(points)))
    gradients = np.empty((len(cones.start), len(points), 3))
    for i in range(len(cones.start)):
        distances[i], gradients[i] = _one_cone(cones, i, points)
    nearest = distances.min(axis=0)
    weights = np.exp((nearest - distances) / blend)
    total = weights.sum(axis=0)
    gradient = np.einsum("np,npd->pd", weights / total, gradients)
    return nearest - blend * np.log(total), gradient


def _one_cone(cones: Cones, i: int, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    axis = cones.end[i] - cones.start[i]
    length = max(float(axis @ axis), 1e-30)
    along = np.clip((points - cones.start[i]) @ axis / length, 0.0, 1.0)
    taper = cones.end_radius[i] - cones.start_radius[i]
    offset = points - cones.start[i] - along[:, None] * axis
    norm = np.maximum(np.linalg.norm(offset, axis=1), 1e-12)
    inner = (along > 0.0) & (along < 1.0)
    gradient = offset / norm[:, None] - np.outer(inner * taper / length, axis)
    return norm - cones.start_radius[i] - along * taper, gradient


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
    # Far from every cone the sum stays at a value that means "6 blends outside".
    total = np.full(tuple(counts), np.exp(-6.0))
    for i in range(len(cones.start)):
        first = np.floor((low[i] - origin) / spacing).astype(np.int64)
        last = np.ceil((high[i] - origin) / spacing).astype(np.int64) + 1
        box = tuple(slice(int(a), int(b)) for a, b in zip(first, last, strict=True))
        total[box] += np.exp(-_on_grid(cones, i, [axes[d][box[d]] for d in range(3)]) / blend)
    field = -blend * np.log(total)
    vertices, faces, _, _ = marching_cubes(field, 0.0)  # type: ignore[no-untyped-call]
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
