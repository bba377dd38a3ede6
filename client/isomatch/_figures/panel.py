"""Shapes side by side in three dimensions, with corresponding points in common colours."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from html import escape
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from isomatch._errors import MissingExtra
from isomatch._figures.camera import aligned_view, camera_of
from isomatch._figures.colors import MUTED, Floats, Indices, position_colors, to_hex

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_SURFACE: Final = "#d9d9d9"
_OPACITY: Final = 0.5
"""Opacity of a surface without colours, behind which points remain visible."""

_CLOUD: Final = "#9ca3af"
_CLOUD_SIZE: Final = 2
"""Of points of a cloud: gray where they have no colours; pixels, as on the service's page."""

_MARGIN: Final = 1.05
"""Side of the drawn cube relative to the longest side of the shape."""


@dataclass(frozen=True, eq=False)
class Panel:
    """One shape of a figure.

    Attributes
    ----------
    vertices
        (V, 3) positions, which span what is shown.
    points
        (n, 3) marked points.
    numbers
        (n,) numbers of the points, shown beside the pointer.
    faces
        (F, 3) rows of `vertices`; None where no surface is known.
    colors
        (V, 3) colours of the vertices between 0 and 1; None for a translucent gray surface, or gray
        points of a cloud.
    lines
        (m, 2, 3) ends of lines.
    line_values
        (m,) values of the lines on the figure's colour axis; None for plain lines.
    caption
        Text above.
    view
        (3, 3) directions to the right, up and towards the viewer.
    is_cloud
        Whether the vertices are drawn as points, instead of the faces.
    """

    vertices: Floats
    points: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    numbers: Indices | None = None
    faces: Indices | None = None
    colors: Floats | None = None
    lines: Floats = field(default_factory=lambda: np.zeros((0, 2, 3)))
    line_values: Floats | None = None
    caption: str = ""
    view: Floats = field(default_factory=lambda: np.eye(3))
    is_cloud: bool = False


def plotly_modules() -> tuple[Any, Any]:
    """Return ``plotly.graph_objects`` and ``plotly.subplots``.

    Raises
    ------
    MissingExtra
        plotly is not installed.
    """
    try:
        from plotly import graph_objects, subplots
    except ImportError as error:
        raise MissingExtra("plot", "plotly") from error
    return graph_objects, subplots


def plain(text: str) -> str:
    """Escape a text that plotly would read as HTML or as a formula."""
    return escape(text, quote=False).replace("$", "&#36;").replace("\n", "<br>")


def draw_panels(panels: Sequence[Panel], title: str) -> "Figure":
    """Draw shapes side by side.

    Parameters
    ----------
    panels
        The shapes; row i of all their points is one correspondence. Colours are by position on
        the last shape; the view of the first is turned for the others, to align their points.
    title
        Text above.
    """
    _, subplots = plotly_modules()
    figure = subplots.make_subplots(
        rows=1,
        cols=len(panels),
        specs=[[{"type": "scene"}] * len(panels)],
        subplot_titles=[plain(panel.caption) for panel in panels],
        horizontal_spacing=0.02,
    )
    colors = position_colors(panels[-1].points, panels[-1].vertices)
    first, *others = panels
    add_panel(figure, first, colors, 1)
    for column, panel in enumerate(others, start=2):
        view = aligned_view(first.view, first.points, panel.points)
        add_panel(figure, replace(panel, view=view), colors, column)
    figure.update_layout(title_text=plain(title), showlegend=False)
    return figure


def add_panel(figure: "Figure", panel: Panel, colors: Floats, column: int) -> None:
    """Add a shape to a figure.

    Parameters
    ----------
    figure
        The figure.
    panel
        The shape.
    colors
        (n, 3) colours of its points.
    column
        Column of the figure, from 1, whose subplot is a scene.
    """
    objects, _ = plotly_modules()
    if panel.is_cloud:
        figure.add_trace(_cloud(objects, panel), 1, column)
    elif panel.faces is not None:
        figure.add_trace(_surface(objects, panel, panel.faces), 1, column)
    if len(panel.lines):
        figure.add_trace(_lines(objects, panel), 1, column)
    if len(panel.points):
        markers = {"size": 6, "color": to_hex(colors), "line": {"color": "black", "width": 1}}
        points = objects.Scatter3d(
            **_xyz(panel.points),
            mode="markers",
            marker=markers,
            text=None if panel.numbers is None else [str(number) for number in panel.numbers],
            hovertemplate="%{text}<extra></extra>",
        )
        figure.add_trace(points, 1, column)
    # Cubes of equal proportions: the camera's distance then fits every shape.
    lowest, highest = panel.vertices.min(axis=0), panel.vertices.max(axis=0)
    middle = 0.5 * (lowest + highest)
    reach = 0.5 * _MARGIN * (float((highest - lowest).max()) or 1.0)
    axes = {
        f"{name}axis": {"visible": False, "range": [centre - reach, centre + reach]}
        for name, centre in zip("xyz", middle.tolist(), strict=True)
    }
    figure.update_scenes(aspectmode="cube", camera=camera_of(panel.view), **axes, row=1, col=column)


def _xyz(points: Floats) -> dict[str, Floats]:
    return dict(zip("xyz", points.T, strict=True))


def _surface(objects: Any, panel: Panel, faces: Indices) -> Any:
    corners = dict(zip("ijk", faces.T, strict=True))
    if panel.colors is None:
        look: dict[str, Any] = {"color": _SURFACE, "opacity": _OPACITY}
    else:
        look = {"vertexcolor": to_hex(panel.colors)}
    return objects.Mesh3d(**_xyz(panel.vertices), **corners, **look, hoverinfo="skip")


def _cloud(objects: Any, panel: Panel) -> Any:
    color = _CLOUD if panel.colors is None else to_hex(panel.colors)
    marker = {"size": _CLOUD_SIZE, "color": color, "line": {"width": 0}}
    return objects.Scatter3d(
        **_xyz(panel.vertices), mode="markers", marker=marker, hoverinfo="skip"
    )


def _lines(objects: Any, panel: Panel) -> Any:
    # NaN separates the lines of one trace.
    ends = np.concatenate([panel.lines, np.full((len(panel.lines), 1, 3), np.nan)], axis=1)
    line: dict[str, Any] = {"color": MUTED, "width": 2}
    if panel.line_values is not None:
        line = {"color": np.repeat(panel.line_values, 3), "coloraxis": "coloraxis", "width": 6}
    return objects.Scatter3d(**_xyz(ends.reshape(-1, 3)), mode="lines", line=line, hoverinfo="skip")
