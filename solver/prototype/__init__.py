"""Shape prototypes: distributions of structures over a class, and matching with them, section 5."""

from solver.prototype.archive import prototype_from_bytes, prototype_to_bytes
from solver.prototype.distributions import Example
from solver.prototype.examples import (
    CorrespondingExamples,
    connected_examples,
    given_examples,
    matched_examples,
)
from solver.prototype.learning import learn_prototype
from solver.prototype.matching import match_prototype
from solver.prototype.options import PrototypeOptions
from solver.prototype.prototype import Prototype
from solver.prototype.surfaces import ExampleSurface, SurfaceSpectra

__all__ = [
    "CorrespondingExamples",
    "Example",
    "ExampleSurface",
    "Prototype",
    "PrototypeOptions",
    "SurfaceSpectra",
    "connected_examples",
    "given_examples",
    "learn_prototype",
    "match_prototype",
    "matched_examples",
    "prototype_from_bytes",
    "prototype_to_bytes",
]
