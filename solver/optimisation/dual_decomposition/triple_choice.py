"""Choice of triples: those that raise the bound most, no two of which share a pair."""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel
from solver.optimisation.dual_decomposition.groups import Groups, Side, numbers
from solver.optimisation.dual_decomposition.pairs import PairSubproblems
from solver.optimisation.dual_decomposition.triples import (
    Triples,
    shape_of,
    solve,
    triples_of,
)

_MOST_WORK = 200_000_000
"""Combinations of three candidates that are tried at most: about a second."""
_LEAST_GAIN = 1e-6
"""Least gain of a triple, relative to the sum of the pairs' minima."""


def choose_triples(pairs: PairSubproblems, most: int, taken: BoolArray) -> Triples:
    """Triples that gain most over their pairs at the present costs, no two sharing a pair.

    Parameters
    ----------
    pairs
        The pairs of one side, minimised.
    most
        Largest number of triples.
    taken
        (G,) pairs that are in a triple already; those of the triples chosen are marked.

    Returns
    -------
    Triples
        None where none gains anything.
    """
    number = numbers(pairs.side, pairs.groups)
    threshold = _LEAST_GAIN * float(np.abs(pairs.minima).sum())
    points, gains = _gains(
        pairs.side, pairs.groups, number, pairs.unary, pairs.pairwise, pairs.minima,
        pairs.optional, pairs.choices, taken, threshold, _MOST_WORK,
    )  # fmt: skip
    chosen = []
    for k in np.argsort(-gains, kind="stable"):
        p, q, r = points[k]
        members = [number[p, q], number[p, r], number[q, r]]
        if not taken[members].any():
            taken[members] = True
            chosen.append(points[k])
        if len(chosen) == most:
            break
    return triples_of(pairs.side, pairs.groups, np.array(chosen, dtype=np.int64))


@kernel
def _gains(
    side: Side,
    groups: Groups,
    number: IntArray,
    unary: FloatArray,
    pairwise: FloatArray,
    minima: FloatArray,
    optional: bool,
    choices: IntArray,
    taken: BoolArray,
    threshold: float,
    most_work: int,
) -> tuple[IntArray, FloatArray]:
    """All triples of points that gain more than a threshold over their pairs, and their gains."""
    count = len(side.first) - 1
    found = []
    gains = []
    work = 0
    for p in range(count):
        for q in range(p + 1, count):
            a = number[p, q]
            if a < 0 or taken[a]:
                continue
            for r in range(q + 1, count):
                b, c = number[p, r], number[q, r]
                if b < 0 or c < 0 or taken[b] or taken[c] or _agree(choices, a, b, c):
                    continue
                shape = shape_of(side, np.array([p, q, r]))
                work += shape[0] * shape[1] * shape[2]
                if work > most_work:
                    break
                best = _least(groups, shape, (a, b, c), unary, pairwise, optional)
                gain = best - minima[a] - minima[b] - minima[c]
                if gain > threshold:
                    found.append((p, q, r))
                    gains.append(gain)
    points_found = np.empty((len(found), 3), dtype=np.int64)
    for i in range(len(found)):
        points_found[i, 0], points_found[i, 1], points_found[i, 2] = found[i]
    return points_found, np.array(gains)


@kernel
def _agree(choices: IntArray, a: int, b: int, c: int) -> bool:
    """Return whether the minimisers of three pairs are a common choice for their points."""
    first: bool = choices[a, 0] == choices[b, 0]
    return first and choices[a, 1] == choices[c, 0] and choices[b, 1] == choices[c, 1]


@kernel
def _least(
    groups: Groups,
    shape: tuple[int, int, int],
    members: tuple[int, int, int],
    unary: FloatArray,
    pairwise: FloatArray,
    optional: bool,
) -> float:
    """Minimum of the costs of three pairs together."""
    (k, m, n), (a, b, c) = shape, members
    ua, ub, uc = groups.unary[a], groups.unary[b], groups.unary[c]
    ea, eb, ec = groups.pairwise[a], groups.pairwise[b], groups.pairwise[c]
    blocks = (
        pairwise[ea : ea + k * m].reshape(k, m),
        pairwise[eb : eb + k * n].reshape(k, n),
        pairwise[ec : ec + m * n].reshape(m, n),
    )
    least: float = solve(
        unary[ua : ua + k] + unary[ub : ub + k],
        unary[ua + k : ua + k + m] + unary[uc : uc + m],
        unary[ub + k : ub + k + n] + unary[uc + m : uc + m + n],
        blocks,
        np.empty(0),
        optional,
    )[0]
    return least
