"""Pictures of results, and geometry for drawing on the page."""

from worker.pictures.coloring import colors_by_place, transferred_colors
from worker.pictures.components_picture import draw_components
from worker.pictures.geometry import packed_geometry, packed_prototype
from worker.pictures.heat_map import draw_matrix, separate_ticks
from worker.pictures.hypothesis import Hypothesis, NoAlternative, hypothesis_of
from worker.pictures.match_picture import draw_match, draw_prototype_match
from worker.pictures.view import View, source_view, target_view

__all__ = [
    "Hypothesis",
    "NoAlternative",
    "View",
    "colors_by_place",
    "draw_components",
    "draw_match",
    "draw_matrix",
    "draw_prototype_match",
    "hypothesis_of",
    "packed_geometry",
    "packed_prototype",
    "separate_ticks",
    "source_view",
    "target_view",
    "transferred_colors",
]
