"""Incumbents: the m best correspondences known, whose energies prune a search."""

from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import UNMATCHED, add_triple_costs, costs_of_triples
from solver.optimisation.reparametrisation import ReparametrisedCosts

OPEN = -2
"""Marks a source point that is not decided."""


class Incumbents(NamedTuple):
    """The m best correspondences so far, in arrays for compiled code.

    Attributes
    ----------
    energies
        (m,) ascending, ``inf`` where there is none yet.
    chosen
        (m, N) candidate of each source point, `UNMATCHED` for none.
    explored
        (m,) whether the neighbours have been looked at.
    """

    energies: FloatArray
    chosen: IntArray
    explored: BoolArray

    @classmethod
    def none(cls, m: int, n_sources: int) -> "Incumbents":
        """Return incumbents without a correspondence, with a capacity of m."""
        chosen = np.full((m, n_sources), UNMATCHED, dtype=np.int64)
        return cls(np.full(m, np.inf), chosen, np.zeros(m, dtype=np.bool_))


@kernel
def keep(found: Incumbents, energy: float, chosen: IntArray) -> None:
    """Insert a correspondence in the sorted list, if it belongs there and is not in it.

    Parameters
    ----------
    found
        Improved in place.
    energy
        By :func:`energy_of`, so that what is in the list already has exactly the same.
    chosen
        (N,) the correspondence.
    """
    energies = found.energies
    last = len(energies) - 1
    if not energy < energies[last]:
        return
    place = np.searchsorted(energies, energy)
    while energies[place] == energy:
        if (found.chosen[place] == chosen).all():
            return
        place += 1
    for k in range(last, place, -1):
        energies[k] = energies[k - 1]
        found.chosen[k] = found.chosen[k - 1]
        found.explored[k] = found.explored[k - 1]
    energies[place] = energy
    found.chosen[place] = chosen
    found.explored[place] = False


@kernel
def energy_of(own: ReparametrisedCosts, chosen: IntArray) -> float:
    """Energy of a correspondence; infinite where candidates exclude one another.

    Parameters
    ----------
    own
        Costs of the problem.
    chosen
        (N,) candidate of each source point, `UNMATCHED` for none.
    """
    unary, pairwise, occlusion = own.unary, own.pairwise, own.occlusion
    energy: float = costs_of_triples(own.triples, chosen).sum()
    for x in range(len(chosen)):
        a = chosen[x]
        if a < 0:
            energy += occlusion[x]
            continue
        energy += unary[a]
        for other in range(x):
            if chosen[other] >= 0:
                energy += pairwise[chosen[other], a]
    return energy


def dive(
    found: Incumbents,
    own: ReparametrisedCosts,
    reparametrised: ReparametrisedCosts,
    rows: IntArray,
    *,
    everywhere: bool = False,
) -> None:
    """Look for incumbents: complete each choice of one point greedily, then change single points.

    Parameters
    ----------
    found
        Improved in place, until no change of one point improves it.
    own
        Costs of the problem.
    reparametrised
        Costs by which greedy choices are made.
    rows
        (N+1,) candidates of each source point.
    everywhere
        Whether to complete each choice of every point.
    """
    _dive(found, own, reparametrised, rows, everywhere)
    explore(found, own, rows)


@kernel
def _dive(
    found: Incumbents,
    own: ReparametrisedCosts,
    reparametrised: ReparametrisedCosts,
    rows: IntArray,
    everywhere: bool,
) -> None:
    n = len(rows) - 1
    unary, pairwise = reparametrised.unary, reparametrised.pairwise
    occlusion = reparametrised.occlusion
    chosen = np.empty(n, dtype=np.int64)
    start = _most_different(unary, occlusion, rows, np.full(n, OPEN))
    place, last = (0, rows[n]) if everywhere else (rows[start], rows[start + 1])
    for first in range(place, last):
        chosen[:] = OPEN
        costs = unary.copy()
        x, a = int(np.searchsorted(rows, first, side="right")) - 1, first
        for _ in range(n):
            chosen[x] = a
            if a >= 0:
                row = pairwise[a]
                for b in range(len(costs)):
                    costs[b] += row[b]
            x = _most_different(costs, occlusion, rows, chosen)
            if x < 0:
                break
            a, least = UNMATCHED, occlusion[x]
            for b in range(rows[x], rows[x + 1]):
                if costs[b] < least:
                    a, least = b, costs[b]
        keep(found, energy_of(own, chosen), chosen)


@kernel
def _most_different(
    costs: FloatArray, occlusion: FloatArray, rows: IntArray, chosen: IntArray
) -> int:
    """Open point whose candidates cost most on average above the cheapest; -1 if none is open."""
    best, most = -1, -np.inf
    for x in range(len(chosen)):
        if chosen[x] != OPEN:
            continue
        count, total, least = 0, 0.0, occlusion[x]
        for b in range(rows[x], rows[x + 1]):
            if costs[b] < np.inf:
                count += 1
                total += costs[b]
                least = min(least, costs[b])
        difference = total / count - least if count else np.inf
        if difference > most or best < 0:
            best, most = x, difference
    return best


@kernel
def explore(found: Incumbents, own: ReparametrisedCosts, rows: IntArray) -> None:
    """Change single points of the best correspondences, until none of the changes is among them."""
    m = len(found.energies)
    k = 0
    while k < m and found.energies[k] < np.inf:
        if found.explored[k]:
            k += 1
            continue
        found.explored[k] = True
        chosen, energy = found.chosen[k].copy(), found.energies[k]
        for x in range(len(rows) - 1):
            _change(found, own, rows, chosen, energy, x)
        k = 0


@kernel
def _change(
    found: Incumbents,
    own: ReparametrisedCosts,
    rows: IntArray,
    chosen: IntArray,
    energy: float,
    x: int,
) -> None:
    """Keep what is better of the correspondences that differ at point x."""
    unary, pairwise, occlusion = own.unary, own.pairwise, own.occlusion
    present = chosen[x]
    first, last = rows[x], rows[x + 1]
    costs = unary[first:last].copy()
    for other in range(len(chosen)):
        if other != x and chosen[other] >= 0:
            row = pairwise[chosen[other], first:last]
            for i in range(len(costs)):
                costs[i] += row[i]
    add_triple_costs(own.triples, chosen, x, costs)
    rest = energy - (occlusion[x] if present < 0 else costs[present - first])
    worst = found.energies[len(found.energies) - 1]
    for i in range(-1, len(costs)):
        cost = occlusion[x] if i < 0 else costs[i]
        a = UNMATCHED if i < 0 else first + i
        if a == present or not rest + cost < worst:
            continue
        chosen[x] = a
        keep(found, energy_of(own, chosen), chosen)
        worst = found.energies[len(found.energies) - 1]
    chosen[x] = present
