"""Shape prototypes: distributions of structures over a class, and matching with them, section 5."""

from solver.prototype.archive import prototype_from_bytes, prototype_to_bytes
from solver.prototype.learning import (
    CorrespondingExamples,
    Example,
    connected_examples,
    given_examples,
    learn_prototype,
    matched_examples,
)
from solver.prototype.matching import match_prototype
from solver.prototype.options import PrototypeOptions, PrototypeStructures
from solver.prototype.prototype import (
    LearnedDescriptors,
    LearnedDistances,
    Prototype,
    all_pairs,
)
from solver.prototype.surfaces import (
    KEPT_VERTICES,
    MOST_FACES,
    MOST_SURFACES,
    MOST_VERTICES,
    ExampleSurface,
    SurfaceSpectra,
    example_surfaces,
    nearest_surfaces,
)

__all__ = [
    "KEPT_VERTICES",
    "MOST_FACES",
    "MOST_SURFACES",
    "MOST_VERTICES",
    "CorrespondingExamples",
    "Example",
    "ExampleSurface",
    "LearnedDescriptors",
    "LearnedDistances",
    "Prototype",
    "PrototypeOptions",
    "PrototypeStructures",
    "SurfaceSpectra",
    "all_pairs",
    "connected_examples",
    "example_surfaces",
    "given_examples",
    "learn_prototype",
    "match_prototype",
    "matched_examples",
    "nearest_surfaces",
    "prototype_from_bytes",
    "prototype_to_bytes",
]
