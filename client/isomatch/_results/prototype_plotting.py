"""Figures of prototypes."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from isomatch._results.plotting import new_figure
from isomatch._results.prototype_points import PrototypePoints
from isomatch._results.surface_plotting import Scene, draw_scene, place_colors

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

_MAP: Final = "viridis"
_FEW: Final = 40
_MOST: Final = 99.0
"""Percentile of the variations at which colours end: single ones would take them all."""


def plot_points(known: PrototypePoints, title: str) -> "Figure":
    """Draw the points of a prototype, and how much their distances vary.

    Parameters
    ----------
    known
        The points.
    title
        Goes above.
    """
    figure = new_figure(12.0, 5.5)
    from matplotlib import colormaps
    from matplotlib.colors import Normalize

    variation = variations(known)
    scale = Normalize(0.0, float(np.nanpercentile(variation, _MOST)) or 1.0)
    bones = known.bones
    scene = replace(
        prototype_scene(known, known.positions, "its points, joined by the shortest distances"),
        bone_colors=colormaps[_MAP](scale(variation[bones[:, 0], bones[:, 1]]))[:, :3],
    )
    # Its type is that of flat axes.
    body: Any = figure.add_subplot(1, 2, 1, projection="3d")
    draw_scene(body, scene, place_colors(known.positions, known.positions), scene.view)
    if len(known.positions) <= _FEW:
        for number, place in enumerate(known.positions):
            body.text(*place, f"  {number}", fontsize=8, zorder=4)
    matrix = figure.add_subplot(1, 2, 2)
    image = matrix.imshow(variation, cmap=_MAP, norm=scale, interpolation="nearest")
    figure.colorbar(image, ax=matrix, label="standard deviation / mean of the distance")
    matrix.set_xlabel("point")
    matrix.set_ylabel("point")
    figure.suptitle(title, parse_math=False)
    return figure


def prototype_scene(known: PrototypePoints, points: Floats, caption: str) -> Scene:
    """Return what is drawn of a prototype: its points, and the reference's surface if it is known.

    Parameters
    ----------
    known
        The prototype.
    points
        (n, 3) those that stand out.
    caption
        Goes below.
    """
    surface, bones = known.surface, known.bones
    if surface is None:
        return Scene(known.positions, points, bones=known.positions[bones], caption=caption)
    return Scene(
        surface.vertices, points, surface.faces, bones=known.positions[bones], caption=caption
    )


def variations(known: PrototypePoints) -> Floats:
    """Return standard deviations over means of the distances, (N, N); NaN on the diagonal."""
    means = known.mean_distances.copy()
    np.fill_diagonal(means, np.nan)
    ratios: Floats = known.spreads / np.where(means == 0.0, np.nan, means)
    return ratios
