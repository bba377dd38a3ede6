"""The points of a prototype and the variation of their distances."""

from typing import TYPE_CHECKING, Final

import numpy as np

from isomatch._figures.colors import COLOR_SCALE, Floats, position_colors
from isomatch._figures.panel import Panel, add_panel, plain, plotly_modules

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_TOP: Final = 99.0
"""Percentile of the variations at the end of the colour scale, so that outliers do not span it."""


def draw_prototype(panel: Panel, variation: Floats, title: str) -> "Figure":
    """Draw a prototype: its points in space on the left, a matrix of variations on the right.

    Parameters
    ----------
    panel
        The points, and lines among them with their variations.
    variation
        Standard deviation over mean of the distance of every two points, (N, N); NaN where it is
        undefined.
    title
        Text above.
    """
    objects, subplots = plotly_modules()
    figure = subplots.make_subplots(
        rows=1,
        cols=2,
        specs=[[{"type": "scene"}, {"type": "xy"}]],
        subplot_titles=[plain(panel.caption), "variation of distances"],
    )
    add_panel(figure, panel, position_colors(panel.points, panel.points), 1)
    hover = "%{y}, %{x}: %{z:.3g}<extra></extra>"
    matrix = objects.Heatmap(z=variation, coloraxis="coloraxis", hovertemplate=hover)
    figure.add_trace(matrix, 1, 2)
    figure.update_xaxes(title_text="point", constrain="domain", showgrid=False)
    figure.update_yaxes(title_text="point", autorange="reversed", scaleanchor="x", showgrid=False)
    figure.update_layout(
        title_text=plain(title),
        showlegend=False,
        plot_bgcolor="white",
        coloraxis={
            "colorscale": COLOR_SCALE,
            "cmin": 0.0,
            "cmax": float(np.nanpercentile(variation, _TOP)) or 1.0,
            "colorbar": {"title": {"text": "standard deviation / mean"}},
        },
    )
    return figure
