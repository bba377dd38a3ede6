"""Results as arrays, and their figures."""

from isomatch._results.dissimilarities import Dissimilarities, PartialDissimilarities
from isomatch._results.geometry import Geometry
from isomatch._results.match import Match
from isomatch._results.prototype_points import PrototypePoints
from isomatch._results.prototypes import Example, LearnedPrototype, Prototype
from isomatch._results.result import Drawable, GeometrySource, Result, is_prototype
from isomatch._results.surface_plotting import Scene, place_colors, plot_scenes, surface_colors
from isomatch._results.view import View

__all__ = [
    "Dissimilarities",
    "Drawable",
    "Example",
    "Geometry",
    "GeometrySource",
    "LearnedPrototype",
    "Match",
    "PartialDissimilarities",
    "Prototype",
    "PrototypePoints",
    "Result",
    "Scene",
    "View",
    "is_prototype",
    "place_colors",
    "plot_scenes",
    "surface_colors",
]
