"""Results of jobs as arrays, and what their figures are drawn from."""

from isomatch._results.dissimilarities import Dissimilarities, PartialDissimilarities
from isomatch._results.geometry import Geometry
from isomatch._results.match import Match
from isomatch._results.prototype_points import PrototypePoints
from isomatch._results.prototypes import Example, LearnedPrototype, Prototype
from isomatch._results.result_document import Drawable, DrawableSource, Result, is_prototype

__all__ = [
    "Dissimilarities",
    "Drawable",
    "DrawableSource",
    "Example",
    "Geometry",
    "LearnedPrototype",
    "Match",
    "PartialDissimilarities",
    "Prototype",
    "PrototypePoints",
    "Result",
    "is_prototype",
]
