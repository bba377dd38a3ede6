"""Learning a prototype from examples, section 5."""

from solver.prototype.learning.carrying import comes_back
from solver.prototype.learning.distributions import Example, discriminant_axes
from solver.prototype.learning.examples import (
    CorrespondingExamples,
    connected_examples,
    given_examples,
    matched_examples,
)
from solver.prototype.learning.learning import learn_prototype

__all__ = [
    "CorrespondingExamples",
    "Example",
    "comes_back",
    "connected_examples",
    "discriminant_axes",
    "given_examples",
    "learn_prototype",
    "matched_examples",
]
