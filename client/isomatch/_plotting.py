"""Figures of results, by matplotlib, which comes with ``pip install isomatch[plot]``."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from isomatch._errors import MissingExtra
from isomatch._geometry import Geometry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

_SKIN: Final = 0.87
_LIGHT: Final = np.array([-0.35, -0.76, 0.55])
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


def plot_correspondence(
    surfaces: Sequence[Geometry], points: Sequence[Floats], title: str
) -> "Figure":
    """Draw shapes side by side, corresponding points in common colours.

    Parameters
    ----------
    surfaces
        The shapes.
    points
        Points of each, (n, 3): one row of all of them is one point and its correspondents. The
        colours tell where the first has them.
    title
        Goes above.
    """
    figure = new_figure(5.5 * len(surfaces), 5.5)
    colors = place_colors(points[0])
    for place, (surface, places) in enumerate(zip(surfaces, points, strict=True), start=1):
        # Its type is that of flat axes.
        axes: Any = figure.add_subplot(1, len(surfaces), place, projection="3d")
        # No point is hidden behind the surface, which is seen through.
        axes.computed_zorder = False
        axes.add_collection3d(_skin(surface))
        axes.scatter(
            *places.T,
            c=colors,
            s=42,
            depthshade=False,
            edgecolors="black",
            linewidths=0.6,
            zorder=3,
        )
        middle, size = _box(surface)
        for name, centre in zip("xyz", middle, strict=True):
            getattr(axes, f"set_{name}lim")(centre - size, centre + size)
        axes.set_box_aspect((1.0, 1.0, 1.0), zoom=1.5)
        axes.view_init(**_view(surface))
        axes.set_axis_off()
    figure.suptitle(title)
    return figure


def place_colors(points: Floats) -> Floats:
    """Colours of points, (n, 3) between 0 and 1, alike for those that are near one another."""
    if not len(points):
        return np.zeros((0, 3))
    lowest = points.min(axis=0)
    size = np.ptp(points, axis=0)
    shares = (points - lowest) / np.where(size > 0.0, size, 1.0)
    colors: Floats = 0.08 + 0.84 * shares
    return colors


def _view(surface: Geometry) -> dict[str, Any]:
    """From where a shape is looked at: along its thinner side, standing on as much as it can."""
    used = surface.vertices[np.unique(surface.faces)]

    def support(axis: int) -> float:
        height = used[:, axis]
        lowest = height <= height.min() + 0.1 * np.ptp(height)
        return float(np.delete(used[lowest], axis, axis=1).std(axis=0).sum())

    # Files have either axis upwards; azimuths are counted from the axis that follows it.
    up = max((1, 2), key=support)
    first, second = (np.ptp(used[:, (up + step) % 3]) for step in (1, 2))
    azimuth = 20.0 if first < second else 110.0
    return {"elev": 12.0, "azim": azimuth, "vertical_axis": "xyz"[up]}


def _skin(surface: Geometry) -> Any:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    light = np.abs(normals @ _LIGHT) / np.where(lengths > 0.0, lengths, 1.0)
    shade = _SKIN * (0.6 + 0.4 * light / np.linalg.norm(_LIGHT))
    colors = np.repeat(shade[:, None], 3, axis=1)
    return Poly3DCollection(
        corners, facecolors=np.column_stack([colors, np.full(len(colors), 0.45)])
    )


def _box(surface: Geometry) -> tuple[Floats, float]:
    used = surface.vertices[np.unique(surface.faces)]
    lowest, highest = used.min(axis=0), used.max(axis=0)
    return 0.5 * (lowest + highest), 0.5 * float((highest - lowest).max())


def plot_matrix(
    matrix: Floats, names: Sequence[str], labels: Sequence[str] | None, title: str
) -> "Figure":
    """Draw dissimilarities as a heat map, in the order of the labels if there are any.

    Parameters
    ----------
    matrix
        Dissimilarities, (K, K).
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
