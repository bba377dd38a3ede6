"""Interactive figures by plotly, made of plain arrays.

plotly comes with ``pip install isomatch[plot]`` and is imported when a figure is drawn. Pictures
(PNG) are drawn by the service: :meth:`isomatch.Job.picture`.
"""

from isomatch._figures.colors import Floats, Indices, position_colors, surface_colors
from isomatch._figures.heat_map import draw_dissimilarities
from isomatch._figures.panel import Panel, draw_panels
from isomatch._figures.prototype import draw_prototype

__all__ = [
    "Floats",
    "Indices",
    "Panel",
    "draw_dissimilarities",
    "draw_panels",
    "draw_prototype",
    "position_colors",
    "surface_colors",
]
