"""Learning a prototype from examples, section 5."""

from solver.prototype.learning.discriminant import discriminant_axes
from solver.prototype.learning.examples import (
    CorrespondingExamples,
    connected_examples,
    given_examples,
)
from solver.prototype.learning.learning import learn_prototype
from solver.prototype.learning.matched import matched_examples
from solver.prototype.learning.observations import Example
from solver.prototype.learning.propagation import is_cycle_consistent

__all__ = [
    "CorrespondingExamples",
    "Example",
    "connected_examples",
    "discriminant_axes",
    "given_examples",
    "is_cycle_consistent",
    "learn_prototype",
    "matched_examples",
]
