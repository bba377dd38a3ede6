"""A dissimilarity matrix as a heat map, as Figure 4: dark cells are similar shapes."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, PowerNorm

from broker.contracts import DissimilarityResult
from solver.arrays import FloatArray, IntArray
from worker.pictures.canvas import FAINT, INK, new_figure, png, shortened

COLORMAP: Final = "viridis"
"""The colour scale, as on the page (service/page/static/heat_map.js)."""

UPPER_QUANTILE: Final = 0.98
"""Dissimilarities above this quantile have the last colour, likewise."""

LEAST_CLIPPED: Final = 50
"""Pairs from which on they have: of few, none is an outlier."""

MOST_NUMBERED: Final = 12
"""Shapes up to which cells have their numbers written in them, likewise."""

_CELL_DIGITS = 2
_TICK_DIGITS = 3
_INCHES = 9.6, 8.6
MOST_NAMES: Final = 40
"""Shapes that are named one by one, likewise."""

_MOST_CLASSES = 60
"""Classes that are named, and separated by lines."""

_LONGEST_NAME = 22
"""Characters of a shortened name."""

LIGHT: Final = 0.44
"""Share of the colour scale from which on black has the higher contrast: 4.5 or more, as white
has below."""

_LABEL = 0.03
"""Height of a label as a fraction of that of the colour bar."""


@dataclass(frozen=True)
class _Block:
    """Consecutive rows of one class."""

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
        (K,) names of the shapes.

    Returns
    -------
    PNG, the same for the same matrix.
    """
    order = _order(result.labels, len(names))
    matrix = np.array(result.matrix)[np.ix_(order, order)]
    blocks = _blocks(result.labels, order)
    figure = new_figure(_INCHES)
    axes = figure.add_axes((0.16, 0.17, 0.72, 0.73))
    pairs = matrix[np.triu_indices(len(matrix), 1)]
    end = scale_end(pairs)
    # The square root tells small dissimilarities apart, which decide the nearest neighbours.
    norm = PowerNorm(0.5, 0.0, end, clip=True)
    image = axes.imshow(matrix, norm=norm, cmap=COLORMAP, interpolation="nearest", aspect="equal")
    bar = figure.colorbar(image, cax=figure.add_axes((0.905, 0.17, 0.022, 0.73)))
    ticks = separate_ticks([*(tick for tick in bar.get_ticks() if tick < end), end], norm)
    clipped = bool(pairs.max() > end)
    bar.set_ticks(
        ticks,
        labels=[*(digits(tick, _TICK_DIGITS) for tick in ticks[:-1]), _end_label(end, clipped)],
    )
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=8, colors=FAINT, length=2)
    if len(names) <= MOST_NUMBERED:
        _write_numbers(axes, matrix, norm)
    _label_axes(axes, [names[k] for k in order], blocks)
    title, subtitle = _captions(result)
    figure.text(0.52, 0.955, title, ha="center", fontsize=14, color=INK)
    figure.text(0.52, 0.918, subtitle, ha="center", fontsize=10, color=FAINT)
    return png(figure)


def scale_end(pairs: FloatArray) -> float:
    """Return the dissimilarity that has the last colour; 1 if all are 0.

    Parameters
    ----------
    pairs
        (P,) dissimilarities of all pairs.
    """
    quantile = UPPER_QUANTILE if len(pairs) >= LEAST_CLIPPED else 1.0
    return float(np.quantile(pairs, quantile, method="lower")) or 1.0


def separate_ticks(ticks: Sequence[float] | FloatArray, norm: Normalize) -> list[float]:
    """Return the ticks of a colour bar whose labels do not overlap; the greatest take precedence.

    Parameters
    ----------
    ticks
        Values, in ascending order.
    norm
        Position of a value on the bar, from 0 to 1.
    """
    kept: list[float] = []
    for tick in map(float, reversed(ticks)):
        within = norm.vmin is not None and norm.vmax is not None and norm.vmin <= tick <= norm.vmax
        if within and (not kept or float(norm(kept[-1])) - float(norm(tick)) > _LABEL):
            kept.append(tick)
    return kept[::-1]


def _end_label(end: float, clipped: bool) -> str:
    number = digits(end, _TICK_DIGITS)
    return f"\N{GREATER-THAN OR EQUAL TO} {number}" if clipped else number


def _write_numbers(axes: Axes, matrix: FloatArray, norm: Normalize) -> None:
    size = min(11.0, 90.0 / len(matrix))
    for (row, column), value in np.ndenumerate(matrix):
        # The scale begins dark and ends light.
        color = "white" if float(norm(value)) < LIGHT else "black"
        text = digits(float(value), _CELL_DIGITS)
        axes.text(column, row, text, size=size, color=color, ha="center", va="center")


def digits(value: float, significant: int) -> str:
    """Return a number of so many digits, as the page (service/page/static/format.js) writes it."""
    mantissa, exponent = f"{value:.{significant - 1}e}".split("e")
    if value == 0.0 or 1e-3 <= abs(value) < 1e5:
        return f"{float(f'{mantissa}e{exponent}'):.15g}"
    return f"{mantissa}e{int(exponent):+d}"


def _order(labels: Sequence[str] | None, count: int) -> IntArray:
    """Order of the shapes by label; labels in the order of their first shapes."""
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
    if len(names) <= MOST_NAMES:
        places, texts = [float(k) for k in range(len(names))], list(names)
    elif len(blocks) <= _MOST_CLASSES:
        places, texts = [block.middle for block in blocks], [block.label for block in blocks]
    else:
        places, texts = [], []
    texts = [shortened(text, _LONGEST_NAME) for text in texts]
    size = 9.0 if len(places) <= 24 else 6.5
    axes.set_xticks(places, texts, rotation=60, ha="right", rotation_mode="anchor")
    axes.set_yticks(places, texts)
    axes.tick_params(length=0, labelsize=size, colors=INK)
    for text in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        text.set_parse_math(False)


def _captions(result: DissimilarityResult) -> tuple[str, str]:
    count = len(result.shapes)
    parts = [f"{count * (count - 1) // 2:,} pairs"]
    if result.mean_average_precision is not None:
        parts.append(f"mean average precision {100.0 * result.mean_average_precision:.1f} %")
    if result.certified:
        parts.append("all proven minimal")
    parameters = result.parameters
    parts.append(f"{parameters.points} points, {parameters.metrics[0].name.replace('_', ' ')}")
    return f"Dissimilarities of {count:,} shapes", "   ·   ".join(parts)
