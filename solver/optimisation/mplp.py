"""MPLP++: dual block-coordinate ascent over pairs of source points.

Pairs take turns: each receives the costs of its two points, and divides them such that neither
could cost more. Then no pair has a negative cost left, and the least costs of the points add up to
a lower bound, which never falls.

Tourani, Shekhovtsov, Rother and Savchynskyy, "MPLP++: fast, parallel dual block-coordinate ascent
for dense graphical models", ECCV 2018.
"""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import inlined

_Costs = TypeVar("_Costs")


@inlined
def mplp_sweep(
    write_least: Callable[[_Costs, IntArray, int, int, FloatArray, FloatArray], None],
    costs: _Costs,
    rows: IntArray,
    unary: FloatArray,
    messages: FloatArray,
    back: bool,
    turns: tuple[int, int],
) -> None:
    """Let every pair of source points divide its costs anew, in order or in the opposite order.

    A sweep is N turns: in each, one source point meets all later ones.

    Parameters
    ----------
    write_least
        Inlined function of the costs, the rows, points x and y, and an array for the labels of
        each: it writes to the latter the least cost of each label of y with the labels of x, to
        which the former is added.
    costs
        Pairwise costs.
    rows
        (N+1,) labels of source point x are ``rows[x]`` to ``rows[x+1]``.
    unary
        (L,) costs of labels with the costs that were moved to them; changed in place.
    messages
        (N, L) costs moved to each label from its point's pair with each other; changed in place.
    back
        Whether in the opposite order.
    turns
        The first of the turns to take, and the one before which to stop.
    """
    n = len(rows) - 1
    widest = np.diff(rows).max() if n > 0 else 0
    f, g, half, second = np.empty(widest), np.empty(widest), np.empty(widest), np.empty(widest)
    for i in range(turns[0], turns[1]):
        for j in range(i + 1, n):
            x, y = (n - 1 - i, n - 1 - j) if back else (i, j)
            here, there = rows[x], rows[y]
            count, other = rows[x + 1] - here, rows[y + 1] - there
            for a in range(count):
                f[a] = unary[here + a] - messages[y, here + a]
            for b in range(other):
                g[b] = unary[there + b] - messages[x, there + b]
            # Each in turn takes what is left, the first one half of it beforehand.
            write_least(costs, rows, y, x, g, half)
            for a in range(count):
                half[a] = f[a] - 0.5 * (f[a] + half[a])
            write_least(costs, rows, x, y, half, second)
            for b in range(other):
                second[b] += g[b]
                messages[x, there + b] += second[b] - unary[there + b]
                unary[there + b] = second[b]
                g[b] -= second[b]
            write_least(costs, rows, y, x, g, half)
            for a in range(count):
                first = f[a] + half[a]
                messages[y, here + a] += first - unary[here + a]
                unary[here + a] = first
