"""Dissimilarities of a collection as a heat map."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from isomatch._figures.colors import COLOR_SCALE, Floats
from isomatch._figures.panel import plain, plotly_modules

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

UPPER_QUANTILE: Final = 0.98
"""Dissimilarities above this quantile have the last colour, as in pictures and on the page."""

_MOST_NAMES: Final = 40
"""Shapes of which each is named on the axes; more names would overlap."""


def draw_dissimilarities(
    matrix: Floats, names: Sequence[str], labels: Sequence[str] | None, title: str
) -> "Figure":
    """Draw dissimilarities as a heat map, sorted by class if there are labels.

    Parameters
    ----------
    matrix
        Dissimilarities, (K, K); NaN where they are not known yet, which stays empty.
    names
        Names of the shapes.
    labels
        Classes of the shapes, or None.
    title
        Text above.
    """
    objects, _ = plotly_modules()
    order = np.arange(len(matrix)) if labels is None else np.argsort(labels, kind="stable")
    named = [plain(names[place]) for place in order]
    known = matrix[np.triu_indices(len(matrix), 1)]
    known = known[~np.isnan(known)]
    greatest = float(np.quantile(known, UPPER_QUANTILE, method="lower")) if known.size else 0.0
    ordered = matrix[np.ix_(order, order)]
    figure = objects.Figure(
        objects.Heatmap(
            # The square root separates small dissimilarities, which decide the nearest neighbours.
            z=np.sqrt(np.maximum(ordered, 0.0)),
            zmin=0.0,
            zmax=np.sqrt(max(greatest, 0.0)) or 1.0,
            customdata=ordered,
            colorscale=COLOR_SCALE,
            colorbar_title_text="√ dissimilarity",
            text=[[f"{row}, {column}" for column in named] for row in named],
            hovertemplate="%{text}: %{customdata:.4g}<extra></extra>",
            hoverongaps=False,
        )
    )
    ticks: dict[str, Any] = {"showticklabels": False}
    if len(order) <= _MOST_NAMES:
        ticks = {"tickvals": list(range(len(order))), "ticktext": named}
    figure.update_xaxes(**ticks, constrain="domain", showgrid=False)
    figure.update_yaxes(**ticks, autorange="reversed", scaleanchor="x", showgrid=False)
    if labels is not None:
        classes = np.asarray(labels)[order]
        for border in np.flatnonzero(classes[1:] != classes[:-1]) + 0.5:
            figure.add_hline(border, line={"color": "white", "width": 1})
            figure.add_vline(border, line={"color": "white", "width": 1})
    figure.update_layout(title_text=plain(title), plot_bgcolor="white")
    return figure
