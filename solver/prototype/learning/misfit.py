"""How much a target misfits a class: its energy beside those of examples that were left out.

A likelihood by itself says little: how much is usual depends on the class, on the points, and on
how well samples of a target fit them. So examples are left out by turns, and matched with what is
learned from the others. What misfits more than they all do is, as a rule, of another class, or has
parts that are no longer what they were; then the answer should be looked at.
"""

from collections.abc import Sequence

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control
from solver.matching import MAX_COARSE_POINTS, MIN_POINTS, MatchOptions
from solver.prototype.learning.distributions import Observed, learn_distributions
from solver.prototype.matching import match_prototype
from solver.prototype.options import PrototypeOptions

_FEWEST = 4
"""Examples below which none is left out: the others would say too little."""
_TURNS = 8
_MOST = 24
"""Examples that are matched, of all that are left out."""


def left_out_energies(seen: Observed, options: PrototypeOptions, control: Control) -> FloatArray:
    """Energies of examples matched with a prototype of others, at the coarsest level of a match.

    Parameters
    ----------
    seen
        M examples. They are left out by turns, each once, in eight parts at most.
    options
        Of the prototype.
    control
        May cancel.

    Returns
    -------
    (E,) energies per point, ascending: of up to 24 examples, whose order does not matter; none of
    fewer than four examples, or three points.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    count, points = len(seen.examples), min(len(seen.examples[0].vertices), MAX_COARSE_POINTS)
    if count < _FEWEST or points < MIN_POINTS:
        return np.zeros(0)
    turns = min(_TURNS, count)
    quiet = Control(is_cancelled=control.is_cancelled, deadline=control.deadline)
    matching = MatchOptions(points=points)
    energies = []
    for turn, left_out in enumerate(_parts(seen, turns)):
        control.check()
        others = [place for place in range(count) if place not in left_out]
        learned = learn_distributions(seen.chosen(others, points), options, quiet)
        for place in left_out[: _most(turn, turns)]:
            answer = match_prototype(learned, seen.examples[place].shape, matching, quiet)
            energies.append(answer.best.energy / len(answer.best.source))
    return np.sort(np.array(energies))


def _parts(seen: Observed, turns: int) -> Sequence[list[int]]:
    """Places of the examples left out at each turn, whatever their order was."""
    size = seen.samples[seen.metrics[0]].sum(axis=(0, 2))
    order = np.argsort(size, kind="stable")
    return [order[turn::turns].tolist() for turn in range(turns)]


def _most(turn: int, turns: int) -> int:
    """Of the examples left out at a turn, those that are matched."""
    return _MOST // turns + (turn < _MOST % turns)
