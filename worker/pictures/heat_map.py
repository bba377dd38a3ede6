"""A dissimilarity matrix as a picture, after Figure 4: dark is alike, blocks are classes."""

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure

from broker.contracts import DissimilarityResult
from solver.arrays import FloatArray, IntArray

_INK, _FAINT = "#2b2f36", "#6b7280"
_INCHES = 9.6, 8.6
_DOTS_PER_INCH = 140
_MOST_NAMES = 48
"""Rows that are tall enough to be named one by one."""

_MOST_CLASSES = 60
_LONGEST_NAME = 22
_LABEL = 0.03
"""Height of a label, as a share of that of the colour bar."""


@dataclass(frozen=True)
class _Block:
    """Neighbouring rows of one class."""

    label: str
    first: int
    count: int

    @property
    def middle(self) -> float:
        return self.first + 0.5 * (self.count - 1)


def draw_matrix(result: DissimilarityResult, names: Sequence[str]) -> bytes:
    """Draw a dissimilarity matrix, rows and columns in the order of their labels.

    Parameters
    ----------
    result
        The dissimilarities of K shapes.
    names
        (K,) what the shapes are called.

    Returns
    -------
    PNG, the same for the same matrix.
    """
    order = _order(result.labels, len(names))
    matrix = np.array(result.matrix)[np.ix_(order, order)]
    blocks = _blocks(result.labels, order)
    figure = Figure(figsize=_INCHES, dpi=_DOTS_PER_INCH, facecolor="white")
    axes = figure.add_axes((0.16, 0.17, 0.72, 0.73))
    others = matrix[~np.eye(len(matrix), dtype=np.bool_)]
    # Energies are squares: their roots tell the small ones apart, which matter.
    gamma = 0.5 if result.parameters.objective == "l2" else 1.0
    norm = PowerNorm(gamma, 0.0, float(np.quantile(others, 0.98)) or 1.0, clip=True)
    image = axes.imshow(matrix, norm=norm, cmap="magma", interpolation="nearest", aspect="equal")
    bar = figure.colorbar(image, cax=figure.add_axes((0.905, 0.17, 0.022, 0.73)))
    bar.set_ticks(told_apart(bar.get_ticks(), norm))
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=8, colors=_FAINT, length=2)
    _label_axes(axes, [names[k] for k in order], blocks)
    title, subtitle = _captions(result)
    figure.text(0.52, 0.955, title, ha="center", fontsize=14, color=_INK)
    figure.text(0.52, 0.918, subtitle, ha="center", fontsize=10, color=_FAINT)
    png = BytesIO()
    canvas = FigureCanvasAgg(figure)
    canvas.print_figure(png, format="png", dpi=_DOTS_PER_INCH, metadata={"Software": "isomatch"})
    return png.getvalue()


def told_apart(ticks: Sequence[float] | FloatArray, norm: Normalize) -> list[float]:
    """Return ticks on a colour bar whose labels do not touch, the greatest first to stay.

    Parameters
    ----------
    ticks
        Values, in ascending order.
    norm
        Where on the bar, from 0 to 1, a value is.
    """
    kept: list[float] = []
    for tick in map(float, reversed(ticks)):
        within = norm.vmin is not None and norm.vmax is not None and norm.vmin <= tick <= norm.vmax
        if within and (not kept or float(norm(kept[-1])) - float(norm(tick)) > _LABEL):
            kept.append(tick)
    return kept[::-1]


def _order(labels: Sequence[str] | None, count: int) -> IntArray:
    """Shapes of one label together, labels in the order in which they first come."""
    if labels is None:
        return np.arange(count)
    rank = {label: place for place, label in enumerate(dict.fromkeys(labels))}
    return np.argsort([rank[label] for label in labels], kind="stable").astype(np.int64)


def _blocks(labels: Sequence[str] | None, order: IntArray) -> list[_Block]:
    if labels is None:
        return []
    blocks: list[_Block] = []
    first = 0
    for label, rows in groupby(labels[k] for k in order):
        count = len(list(rows))
        blocks.append(_Block(label, first, count))
        first += count
    return blocks


def _label_axes(axes: Axes, names: Sequence[str], blocks: Sequence[_Block]) -> None:
    for side in axes.spines.values():
        side.set_visible(False)
    for block in blocks[1:] if len(blocks) <= _MOST_CLASSES else ():
        for line in (axes.axhline, axes.axvline):
            line(block.first - 0.5, color="white", linewidth=0.8)
    if len(names) <= _MOST_NAMES:
        places, texts = [float(k) for k in range(len(names))], [_short(name) for name in names]
    elif len(blocks) <= _MOST_CLASSES:
        places, texts = [block.middle for block in blocks], [_short(b.label) for b in blocks]
    else:
        places, texts = [], []
    size = 9.0 if len(places) <= 24 else 6.5
    axes.set_xticks(places, texts, rotation=60, ha="right", rotation_mode="anchor")
    axes.set_yticks(places, texts)
    axes.tick_params(length=0, labelsize=size, colors=_INK)
    for text in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        text.set_parse_math(False)


def _captions(result: DissimilarityResult) -> tuple[str, str]:
    count = len(result.shapes)
    parts = [f"{count * (count - 1) // 2:,} pairs"]
    if result.mean_average_precision is not None:
        parts.append(f"mean average precision {100.0 * result.mean_average_precision:.1f} %")
    if result.certified:
        parts.append("every one proven optimal")
    parameters = result.parameters
    parts.append(f"{parameters.points} points, {parameters.metrics[0].name}")
    return f"Dissimilarities of {count:,} shapes", "   ·   ".join(parts)


def _short(name: str) -> str:
    return name if len(name) <= _LONGEST_NAME else name[: _LONGEST_NAME - 3] + "..."
