"""Relaxation of a labelling problem: its subproblems, and the exchanges of costs between them."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.labelling import LabellingProblem, triple_costs
from solver.optimisation.dual_decomposition.exchange import Exchange, used_once
from solver.optimisation.dual_decomposition.groups import (
    NOTHING,
    Side,
    block_positions,
    candidates_of,
    full_costs,
    full_groups,
    sides_of,
    sparse_groups,
)
from solver.optimisation.dual_decomposition.linear import LinearSubproblem
from solver.optimisation.dual_decomposition.maxflow import MaxflowSubproblem
from solver.optimisation.dual_decomposition.pairs import PairSubproblems
from solver.optimisation.dual_decomposition.reduced_costs import reduced_costs
from solver.optimisation.dual_decomposition.triples import (
    TripleSubproblems,
    disjoint_sets,
    triples_of,
)
from solver.optimisation.reparametrisation import ReparametrisedCosts


@dataclass(frozen=True)
class Subproblems:
    """Choice of the subproblems beside the linear one.

    Parameters
    ----------
    source_pairs, target_pairs
        Pairs of source points, of target points. Without pairs of source points, third-order costs,
        which are never negative, are left out of the bound.
    maxflow
        All candidates and pairwise costs without constraints, by roof duality.

    Raises
    ------
    ValueError
        No subproblem with pairwise costs takes part.
    """

    source_pairs: bool = True
    target_pairs: bool = True
    maxflow: bool = False

    def __post_init__(self) -> None:
        if not (self.source_pairs or self.target_pairs or self.maxflow):
            raise ValueError("pairwise costs need a subproblem beside the linear one")


class Subproblem(Protocol):
    """A part of the energy that is minimised on its own."""

    def minimise(self) -> float:
        """Solve the subproblem for its present costs; return the minimum."""
        ...


class Relaxation:
    """Subproblems of a labelling problem, and the present division of its costs among them.

    A kind of subproblem takes part by its ``minimise`` and by the exchanges of costs with those
    that have shares of the same costs; the relaxation knows nothing else of it.

    Parameters
    ----------
    problem
        The labelling problem.
    subproblems
        Choice of the subproblems.

    Attributes
    ----------
    linear
        The linear subproblem.
    """

    def __init__(self, problem: LabellingProblem, subproblems: Subproblems) -> None:
        self._problem = problem
        self.linear = LinearSubproblem(problem)
        self._pairs = _pairs_of_sides(problem, subproblems)
        self._parts: list[Subproblem] = list(self._pairs)
        self._exchanges = [each for pairs in self._pairs for each in pairs.exchanges(self.linear)]
        if len(self._pairs) == 2:
            self._exchanges.append(self._pairs[0].exchange_with(self._pairs[1]))
        if subproblems.maxflow:
            part, exchanges = _maxflow(problem, self._pairs, self.linear)
            self._parts.append(part)
            self._exchanges += exchanges
        self._third = self._third_order() if subproblems.source_pairs else []
        self._minimum = -np.inf

    def _third_order(self) -> list[tuple[IntArray, TripleSubproblems]]:
        """Triple subproblems with the third-order costs, which take over those of their pairs.

        Of several triples with a common pair the first one takes its costs; later ones exchange
        them with it.

        Returns
        -------
        Sets of triples, of which no two share a pair, with their subproblems.
        """
        third, found = self._problem.triples, []
        for members in disjoint_sets(third.points):
            pairs = self._pairs[0]
            triples = triples_of(pairs.side, pairs.groups, third.points[members])
            costs = np.concatenate([third.table(t).ravel() for t in members])
            part = TripleSubproblems(pairs, triples, costs)
            self._parts.append(part)
            self._exchanges += part.exchanges(self.linear)
            found.append((members, part))
        return found

    def minimise(self) -> float:
        """Solve all subproblems; return the lower bound of the energy: the sum of the minima."""
        linear = self.linear.minimise()
        self._minimum = sum(part.minimise() for part in self._parts)
        return linear + self._minimum

    def ascend(self, rise: float) -> None:
        """Move costs along the direction, as far as a linear bound would need to rise by `rise`."""
        norm = sum(exchange.update_direction() for exchange in self._exchanges)
        if norm > 0.0:
            for exchange in self._exchanges:
                exchange.step(rise / norm)

    def reparametrised_costs(self) -> ReparametrisedCosts:
        """Costs of the same correspondences, whose constant is the present bound.

        Memory is 8 bytes times the square of the number of candidates.
        """
        count = self._problem.n_candidates
        slack = np.zeros((count, count))
        for pairs in self._pairs:
            pairs.add_slack(slack)
        linear, problem = self.linear, self._problem
        costs = reduced_costs(problem, linear.unary, linear.partners, slack, self._minimum)
        third = problem.triples
        slacks: dict[int, FloatArray] = {}
        for members, part in self._third:
            slacks.update(zip(members.tolist(), part.slacks(), strict=True))
        if not slacks:
            return costs
        tables = [slacks[t] for t in range(len(third.points))]
        return costs._replace(triples=triple_costs(third.rows, third.points, tables))


def _pairs_of_sides(problem: LabellingProblem, subproblems: Subproblems) -> list[PairSubproblems]:
    """Pair subproblems of the shapes that are to have them, with equal shares of the costs."""
    wanted = subproblems.source_pairs, subproblems.target_pairs
    share = 1.0 / (sum(wanted) + subproblems.maxflow)
    # A target point may stay free unless there are as many as source points, all of which must be
    # matched.
    optional = not problem.must_match_all
    free = optional or problem.n_targets > problem.n_sources
    sides = zip(sides_of(problem), (optional, free), wanted, strict=True)
    return [_pair_subproblems(problem, side, share, may) for side, may, present in sides if present]


def _pair_subproblems(
    problem: LabellingProblem, side: Side, share: float, optional: bool
) -> PairSubproblems:
    """All pairs of points of a shape that have pairwise costs, with a share of these."""
    terms = problem.terms
    x, y = problem.candidates.T
    one, two = terms.first, terms.second
    compatible = (x[one] != x[two]) & (y[one] != y[two])
    one, two, costs = one[compatible], two[compatible], share * terms.costs[compatible]
    if not problem.all_pairs_cost:
        groups, order = sparse_groups(side, one, two)
        return PairSubproblems(side, groups, costs[order], optional)
    groups = full_groups(side)
    pairwise = full_costs(side, groups, problem.pairwise_costs, share)
    pairwise[block_positions(side, groups, one, two)] += costs
    return PairSubproblems(side, groups, pairwise, optional)


def _maxflow(
    problem: LabellingProblem, sides: list[PairSubproblems], linear: LinearSubproblem
) -> tuple[MaxflowSubproblem, list[Exchange]]:
    """Maxflow subproblem with the same share of the pairwise costs as the pairs."""
    base = sides[0] if sides else _pair_subproblems(problem, sides_of(problem)[0], 1.0, True)
    positions = np.flatnonzero(np.isfinite(base.pairwise)).astype(np.int64)
    first, second = (ends[positions] for ends in candidates_of(base.side, base.groups))
    unary = np.zeros(problem.n_candidates)
    part = MaxflowSubproblem(first, second, unary, base.pairwise[positions].copy())
    exchanges = [
        Exchange(
            unary,
            linear.unary,
            np.arange(len(unary)),
            gains=lambda: part.used_unary,
            losses=lambda: used_once(linear.used),
        )
    ]
    if sides:
        inverse = np.full(len(base.pairwise), NOTHING, dtype=np.int64)
        inverse[positions] = np.arange(len(positions))
        exchanges.append(
            Exchange(
                part.pairwise,
                base.pairwise,
                positions,
                gains=lambda: part.used_pairwise,
                losses=lambda: used_once(inverse[base.used_pairwise]),
            )
        )
    return part, exchanges
