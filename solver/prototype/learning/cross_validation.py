"""Cross-validation of a prototype: energies of examples that were left out of the learning.

A likelihood by itself says little: its usual value depends on the class, the points, and how well
samples of a target fit them. So examples are left out in turn and matched with what is learned
from the others. A target of greater energy than all of these is usually of another class, or lacks
parts; its match needs a look.
"""

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control
from solver.matching import MAX_COARSE_POINTS, MIN_POINTS, MatchOptions
from solver.prototype.learning.distributions import learn_distributions
from solver.prototype.learning.observations import Observations
from solver.prototype.matching import match_prototype
from solver.prototype.options import PrototypeOptions

_MIN_EXAMPLES = 4
"""Examples below which none is left out: too few would remain to learn from."""

_FOLDS = 8
"""Parts that the examples are divided into, each left out once."""

_MAX_MATCHED = 24
"""Examples that are matched, of all that are left out: enough for a median and a greatest value."""


def left_out_energies(
    seen: Observations, options: PrototypeOptions, control: Control
) -> FloatArray:
    """Energies of left-out examples at the coarsest level of a match (section 5).

    Parameters
    ----------
    seen
        M examples, divided into at most eight folds.
    options
        Of the prototype.
    control
        May cancel.

    Returns
    -------
    (E,) energies per point, ascending, of up to 24 examples, whatever their order; empty for fewer
    than four examples or three points.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    count, points = len(seen.examples), min(len(seen.examples[0].vertices), MAX_COARSE_POINTS)
    if count < _MIN_EXAMPLES or points < MIN_POINTS:
        return np.zeros(0)
    quiet = control.quiet()
    matching = MatchOptions(points=points)
    energies = []
    folds = _folds(seen, min(_FOLDS, count))
    for fold, left_out in enumerate(folds):
        control.check()
        others = [place for place in range(count) if place not in left_out]
        learned = learn_distributions(seen.chosen(others, points), options, quiet)
        matched = _MAX_MATCHED // len(folds) + (fold < _MAX_MATCHED % len(folds))
        for place in left_out[:matched]:
            answer = match_prototype(learned, seen.examples[place].shape, matching, quiet)
            energies.append(answer.best.energy / len(answer.best.source))
    return np.sort(np.array(energies))


def _folds(seen: Observations, count: int) -> list[list[int]]:
    """Divide the places of the examples by the sum of their distances, whatever their order."""
    size = seen.samples[seen.metrics[0]].sum(axis=(0, 2))
    order = np.argsort(size, kind="stable")
    return [order[fold::count].tolist() for fold in range(count)]
