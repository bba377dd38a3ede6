"""Principal components of a registration as a picture: the mean shape, moved along each."""

from collections.abc import Sequence

import numpy as np

from solver.arrays import FloatArray, IntArray
from worker.pictures.canvas import FAINT, INK, new_figure, png, shortened
from worker.pictures.match_picture import draw_surface
from worker.pictures.scene import Scene
from worker.pictures.view import source_view

_SHOWN = 3
"""Components that are drawn."""

_DEVIATIONS = -2.0, 0.0, 2.0
"""Standard deviations that the mean is moved by."""

_ROW_INCHES = 10.0, 3.4
_LONGEST_NAME = 80


def draw_components(
    mean: FloatArray,
    faces: IntArray,
    components: FloatArray,
    variances: FloatArray,
    explained: Sequence[float],
    title: str,
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

    Returns
    -------
    PNG, the same for the same components.
    """
    count = min(len(components), _SHOWN)
    steps = _DEVIATIONS if count else (0.0,)
    width, height = _ROW_INCHES
    figure = new_figure((width, height * max(count, 1) + 0.6))
    figure.text(0.5, 0.985, shortened(title, _LONGEST_NAME), ha="center", va="top", fontsize=14,
                color=INK, parse_math=False)  # fmt: skip
    used = np.unique(faces)
    centre = mean[used].mean(axis=0)
    view = source_view(mean[used] - centre)
    top = 1.0 - 0.5 / (height * max(count, 1) + 0.6)
    for row in range(max(count, 1)):
        for column, deviations in enumerate(steps):
            vertices = mean - centre
            if count:
                vertices = vertices + deviations * np.sqrt(variances[row]) * components[row]
            axes = figure.add_axes(
                (column / len(steps), top * (1.0 - (row + 1.0) / max(count, 1)) + 0.02,
                 1.0 / len(steps), top / max(count, 1) - 0.05)
            )  # fmt: skip
            axes.set_axis_off()
            axes.set_aspect("equal")
            draw_surface(axes, Scene(view.of(vertices), faces, np.empty((0, 3))))
            axes.autoscale_view()
            axes.set_title(_caption(row, deviations, explained), fontsize=10, color=FAINT)
    return png(figure)


def _caption(row: int, deviations: float, explained: Sequence[float]) -> str:
    if not deviations:
        return "mean"
    share = f" ({100.0 * explained[row]:.0f} % of the variance)"
    return f"component {row + 1}: {deviations:+.0f} standard deviations{share}"
