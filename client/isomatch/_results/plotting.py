"""Figures of results, by matplotlib, which comes with ``pip install isomatch[plot]``."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from isomatch._errors import MissingExtra

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

FAINT: Final = "#6b7280"
"""Colour of what explains."""

_FEW_NAMES: Final = 40


def new_figure(width: float, height: float) -> "Figure":
    """Return an empty figure, which ``matplotlib.pyplot.show()`` shows.

    Raises
    ------
    MissingExtra
        matplotlib is not installed.
    """
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise MissingExtra("plot", "matplotlib") from error
    return pyplot.figure(figsize=(width, height), layout="constrained")


def saved(figure: "Figure", path: str | os.PathLike[str] | None) -> "Figure":
    """Write a figure to a file, if one is named, and return it."""
    if path is not None:
        figure.savefig(path)
    return figure


def plot_matrix(
    matrix: Floats, names: Sequence[str], labels: Sequence[str] | None, title: str
) -> "Figure":
    """Draw dissimilarities as a heat map, in the order of the labels if there are any.

    Parameters
    ----------
    matrix
        Dissimilarities, (K, K); NaN where they are not known yet, which stays white.
    names
        What the shapes are called.
    labels
        Their classes.
    title
        Goes above.
    """
    figure = new_figure(7.0, 6.0)
    order = np.arange(len(matrix)) if labels is None else np.argsort(labels, kind="stable")
    axes = figure.add_subplot()
    image = axes.imshow(matrix[np.ix_(order, order)], cmap="viridis", interpolation="nearest")
    figure.colorbar(image, ax=axes, label="dissimilarity")
    if len(order) <= _FEW_NAMES:
        called = [names[place] for place in order]
        axes.set_xticks(range(len(order)), called, rotation=90, parse_math=False)
        axes.set_yticks(range(len(order)), called, parse_math=False)
    if labels is not None:
        classes = np.asarray(labels)[order]
        for border in np.flatnonzero(classes[1:] != classes[:-1]) + 0.5:
            axes.axhline(border, color="white", linewidth=1.0)
            axes.axvline(border, color="white", linewidth=1.0)
    axes.set_title(title)
    return figure
