"""Pictures of results and packed geometry for the page."""

from worker.pictures.coloring import colors_by_place, colors_carried
from worker.pictures.geometry import packed_geometry
from worker.pictures.heat_map import draw_matrix, told_apart
from worker.pictures.hypothesis import Hypothesis, NoAlternative, hypothesis_of
from worker.pictures.picture import draw_match, draw_prototype_match
from worker.pictures.view import View, source_view

__all__ = [
    "Hypothesis",
    "NoAlternative",
    "View",
    "colors_by_place",
    "colors_carried",
    "draw_match",
    "draw_matrix",
    "draw_prototype_match",
    "hypothesis_of",
    "packed_geometry",
    "source_view",
    "told_apart",
]
