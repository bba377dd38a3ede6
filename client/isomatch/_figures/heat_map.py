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

LEAST_CLIPPED: Final = 50
"""Pairs from which on they have: of few, none is an outlier."""

MOST_NUMBERED: Final = 12
"""Shapes up to which cells have their numbers written in them."""

MOST_NAMES: Final = 40
"""Shapes of which each is named on the axes; more names would overlap."""

_CELL_DIGITS: Final = 2
_TICK_DIGITS: Final = 3
_HOVER_DIGITS: Final = 4

_TICKS: Final = np.linspace(0.0, 1.0, 5)
"""Places of the ticks of the scale, as shares of its end."""


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
        Classes of the shapes, or None; they are drawn in the order of their first shapes.
    title
        Text above.
    """
    objects, _ = plotly_modules()
    order = _order(labels, len(matrix))
    named = [plain(names[place]) for place in order]
    known = matrix[np.triu_indices(len(matrix), 1)]
    known = known[~np.isnan(known)]
    end = scale_end(known)
    ordered = matrix[np.ix_(order, order)]
    texts = _cell_texts(ordered) if len(order) <= MOST_NUMBERED else None
    figure = objects.Figure(
        objects.Heatmap(
            # The square root separates small dissimilarities, which decide the nearest neighbours.
            z=np.sqrt(np.maximum(ordered, 0.0)),
            zmin=0.0,
            zmax=np.sqrt(end),
            customdata=ordered,
            colorscale=COLOR_SCALE,
            colorbar={
                "title": {"text": "dissimilarity", "side": "right"},
                "tickvals": _TICKS * np.sqrt(end),
                "ticktext": _tick_labels(end, clipped=bool((known > end).any())),
            },
            text=texts,
            texttemplate=None if texts is None else "%{text}",
            hovertext=[
                [
                    f"{here}, {there}: {digits(value, _HOVER_DIGITS)}"
                    for there, value in zip(named, row, strict=True)
                ]
                for here, row in zip(named, ordered.tolist(), strict=True)
            ],
            hovertemplate="%{hovertext}<extra></extra>",
            hoverongaps=False,
        )
    )
    ticks: dict[str, Any] = {"showticklabels": False}
    if len(order) <= MOST_NAMES:
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


def _order(labels: Sequence[str] | None, count: int) -> list[int]:
    """Order of the shapes by class; classes in the order of their first shapes."""
    if labels is None:
        return list(range(count))
    rank = {label: place for place, label in enumerate(dict.fromkeys(labels))}
    return sorted(range(count), key=lambda place: rank[labels[place]])


def scale_end(known: Floats) -> float:
    """Return the dissimilarity that has the last colour; 1 if all are 0 or none is known.

    Parameters
    ----------
    known
        (P,) dissimilarities of pairs.
    """
    if not known.size:
        return 1.0
    quantile = UPPER_QUANTILE if known.size >= LEAST_CLIPPED else 1.0
    return max(float(np.quantile(known, quantile, method="lower")), 0.0) or 1.0


def digits(value: float, significant: int) -> str:
    """Return a number of so many digits, as pictures and the page write it; empty for NaN."""
    if np.isnan(value):
        return ""
    mantissa, exponent = f"{value:.{significant - 1}e}".split("e")
    if value == 0.0 or 1e-3 <= abs(value) < 1e5:
        return f"{float(f'{mantissa}e{exponent}'):.15g}"
    return f"{mantissa}e{int(exponent):+d}"


def _tick_labels(end: float, *, clipped: bool) -> list[str]:
    labels = [digits(value, _TICK_DIGITS) for value in (_TICKS**2 * end).tolist()]
    return [*labels[:-1], f"≥ {labels[-1]}"] if clipped else labels


def _cell_texts(matrix: Floats) -> list[list[str]]:
    return [[digits(value, _CELL_DIGITS) for value in row] for row in matrix.tolist()]
