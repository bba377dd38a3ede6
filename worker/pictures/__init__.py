"""Pictures of results, and geometry for drawing on the page."""

from worker.pictures.coloring import colors_by_place
from worker.pictures.components_picture import draw_components
from worker.pictures.geometry import packed_geometry, packed_prototype
from worker.pictures.heat_map import draw_matrix
from worker.pictures.hypothesis import NoAlternative, hypothesis_of
from worker.pictures.match_picture import draw_match, draw_prototype_match
from worker.pictures.view import View, prototype_view, source_view, target_view

__all__ = [
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
    "prototype_view",
    "source_view",
    "target_view",
]
