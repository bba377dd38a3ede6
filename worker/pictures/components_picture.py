"""Principal components of a registration as a picture: the mean shape, moved along each."""

from collections.abc import Sequence

import numpy as np

from solver.arrays import FloatArray, IntArray
from worker.pictures.canvas import FAINT, INK, new_figure, png, shortened
from worker.pictures.match_picture import draw_surface
from worker.pictures.scene import Scene
from worker.pictures.view import View

_SHOWN = 3
"""Components that are drawn."""

_DEVIATIONS = -2.0, 0.0, 2.0
"""Standard deviations that the mean is moved by."""

_MARGIN = 0.04
"""Of the picture of each shape, over its size."""

_ROW_INCHES = 8.0, 2.9
_TITLE_INCHES = 0.6
_LONGEST_NAME = 80


def draw_components(
    mean: FloatArray,
    faces: IntArray,
    components: FloatArray,
    variances: FloatArray,
    explained: Sequence[float],
    title: str,
    view: View,
) -> bytes:
    """Draw the mean shape at −2, 0 and 2 standard deviations of its first three components.

    Parameters
    ----------
    mean, faces
        (V, 3) and (F, 3).
    components, variances, explained
        (C, V, 3), (C,) and (C,); without any, the mean alone is drawn.
    title
        Title of the picture.
    view
        View of the mean.

    Returns
    -------
    PNG, the same for the same components.
    """
    count = min(len(components), _SHOWN)
    rows, steps = max(count, 1), _DEVIATIONS if count else (0.0,)
    width, height = _ROW_INCHES
    total = height * rows + _TITLE_INCHES
    figure = new_figure((width, total))
    figure.text(
        0.5, 1.0 - 0.2 / total, shortened(title, _LONGEST_NAME), ha="center", va="top",
        fontsize=14, color=INK, parse_math=False,
    )  # fmt: skip
    used = np.unique(faces)
    centre = mean[used].mean(axis=0)
    shapes = {
        (row, step): view.of(_moved(mean - centre, row, step, components, variances))
        for row in range(rows)
        for step in steps
    }
    every = np.concatenate([one[used] for one in shapes.values()])
    least, greatest = every.min(axis=0), every.max(axis=0)
    margin = _MARGIN * (greatest - least).max()
    least, greatest = least - margin, greatest + margin
    for (row, step), vertices in shapes.items():
        bottom = height * (rows - 1 - row) / total
        column = steps.index(step)
        box = column / len(steps), bottom + 0.1 / total, 1.0 / len(steps), (height - 0.5) / total
        axes = figure.add_axes(box)
        axes.set_axis_off()
        axes.set_aspect("equal")
        draw_surface(axes, Scene(vertices, faces, np.empty((0, 3))))
        axes.set_xlim(least[0], greatest[0])
        axes.set_ylim(least[1], greatest[1])
        axes.set_title(_caption(row, step, explained), fontsize=10, color=FAINT)
    return png(figure)


def _moved(
    mean: FloatArray, row: int, step: float, components: FloatArray, variances: FloatArray
) -> FloatArray:
    if not step:
        return mean
    moved: FloatArray = mean + step * np.sqrt(variances[row]) * components[row]
    return moved


def _caption(row: int, step: float, explained: Sequence[float]) -> str:
    signed = f"{step:+.0f}".replace("-", "\N{MINUS SIGN}")
    if step or row >= len(explained):
        return f"component {row + 1}, {signed} s.d." if step else "mean"
    return f"mean; component {row + 1} has {100.0 * explained[row]:.0f} % of the variance"
