"""Results of jobs as arrays, and what their figures are drawn from."""

from isomatch._results.array_result import ArrayResult
from isomatch._results.array_transfer import KINDS, Direction, Element, TransferKind
from isomatch._results.batch import Batch, BatchMatch, BatchProgress
from isomatch._results.consistent_maps import CollectionPair, CollectionShape, ConsistentMaps
from isomatch._results.dissimilarities import Dissimilarities, PartialDissimilarities
from isomatch._results.geometry import Geometry
from isomatch._results.match import Match
from isomatch._results.prototype_points import PrototypePoints
from isomatch._results.prototypes import Example, LearnedPrototype, Prototype
from isomatch._results.registration import PrincipalComponent, Registration, Specimen
from isomatch._results.result_document import Drawable, DrawableSource, Result
from isomatch._results.summary import change
from isomatch._results.transfer import Transfer

__all__ = [
    "KINDS",
    "ArrayResult",
    "Batch",
    "BatchMatch",
    "BatchProgress",
    "CollectionPair",
    "CollectionShape",
    "ConsistentMaps",
    "Direction",
    "Dissimilarities",
    "Drawable",
    "DrawableSource",
    "Element",
    "Example",
    "Geometry",
    "LearnedPrototype",
    "Match",
    "PartialDissimilarities",
    "PrincipalComponent",
    "Prototype",
    "PrototypePoints",
    "Registration",
    "Result",
    "Specimen",
    "Transfer",
    "TransferKind",
    "change",
]
