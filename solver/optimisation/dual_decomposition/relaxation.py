"""Which subproblems the energy is split into, and how their costs move between them."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import IntArray
from solver.labelling import LabellingProblem
from solver.optimisation.dual_decomposition.groups import (
    NOTHING,
    Side,
    block_positions,
    candidates_of,
    full_costs,
    full_groups,
    match_full,
    match_sparse,
    sides_of,
    sparse_groups,
)
from solver.optimisation.dual_decomposition.linear import LinearSubproblem
from solver.optimisation.dual_decomposition.maxflow import MaxflowSubproblem
from solver.optimisation.dual_decomposition.pairs import PairSubproblems
from solver.optimisation.dual_decomposition.reduction import reduced_costs
from solver.optimisation.dual_decomposition.shares import Exchange, used_once
from solver.optimisation.dual_decomposition.triple_choice import choose_triples
from solver.optimisation.dual_decomposition.triples import TripleSubproblems
from solver.optimisation.reparametrisation import BoundingCosts

_MOMENTUM = 0.9


@dataclass(frozen=True)
class Subproblems:
    """Which subproblems take part beside the linear one.

    Parameters
    ----------
    source_pairs, target_pairs
        Local subproblems on pairs of source points, of target points.
    maxflow
        All candidates and pairwise costs without constraints, by roof duality.
    triples
        So many local subproblems on triples of points are added, at most, on each side that has
        pairs whenever the bound stagnates. Only for problems with metrics.

    Raises
    ------
    ValueError
        None of the subproblems that know of pairwise costs takes part.
    """

    source_pairs: bool = True
    target_pairs: bool = True
    maxflow: bool = False
    triples: int = 0

    def __post_init__(self) -> None:
        if not (self.source_pairs or self.target_pairs or self.maxflow):
            raise ValueError("pairwise costs need a subproblem beside the linear one")


class Relaxation:
    """The subproblems of one labelling problem, and the present division of its costs.

    Parameters
    ----------
    problem
        The labelling problem.
    subproblems
        Which subproblems take part.
    """

    def __init__(self, problem: LabellingProblem, subproblems: Subproblems) -> None:
        self._problem, self._subproblems = problem, subproblems
        self.linear = LinearSubproblem(problem)
        wanted = subproblems.source_pairs, subproblems.target_pairs, subproblems.maxflow
        share = 1.0 / sum(wanted)
        # A target point may go without partner unless there are as many as source points, all of
        # which must be matched.
        optional = not problem.must_match_all
        spare = optional or problem.n_targets > problem.n_sources
        sides = [
            _pair_subproblems(problem, side, share, may_be_free)
            for side, may_be_free, present in zip(
                sides_of(problem), (optional, spare), wanted[:2], strict=True
            )
            if present
        ]
        self._pairs = sides
        self._unary = [Exchange(s.unary, self.linear.unary, s.candidate_at) for s in sides]
        self._across = _Across(*sides) if len(sides) == 2 else None
        self._maxflow = _Unconstrained(problem, sides, self.linear) if wanted[2] else None
        self._triples = [_TripleBatches(s, self.linear) for s in sides]
        self._minimum = -np.inf

    def minimise(self) -> float:
        """Solve all subproblems; return the lower bound that their minima add up to."""
        bound = self.linear.minimise()
        self._minimum = sum(pairs.minimise() for pairs in self._pairs)
        self._minimum += sum(batch.minimise() for batch in self._triples)
        if self._maxflow is not None:
            self._minimum += self._maxflow.part.minimise()
        return bound + self._minimum

    def ascend(self, gain: float) -> None:
        """Move costs where the bound rises, so far that a linear bound would rise by `gain`."""
        used = self.linear.used
        norm = 0.0
        for pairs, exchange in zip(self._pairs, self._unary, strict=True):
            norm += exchange.turn(pairs.used_unary, pairs.places_of(used), _MOMENTUM)
        if self._across is not None:
            norm += self._across.turn()
        if self._maxflow is not None:
            norm += self._maxflow.turn(used)
        for batch in self._triples:
            norm += batch.turn(used)
        if norm > 0.0:
            for exchange in self._exchanges():
                exchange.step(gain / norm)

    def add_triples(self) -> int:
        """Add triples that gain most at the present costs; return how many."""
        most = self._subproblems.triples
        if most == 0 or not self._problem.all_pairs_cost:
            return 0
        return sum(batch.add(most) for batch in self._triples)

    def bounding_costs(self) -> BoundingCosts:
        """Costs to prune an exact search with; their constant is the present bound.

        Memory is 8 bytes times the square of the number of candidates.
        """
        count = self._problem.n_candidates
        slack = np.zeros((count, count))
        for pairs in self._pairs:
            pairs.add_slack(slack)
        linear = self.linear
        return reduced_costs(self._problem, linear.unary, linear.partners, slack, self._minimum)

    def _exchanges(self) -> list[Exchange]:
        exchanges = list(self._unary)
        if self._across is not None:
            exchanges.append(self._across.exchange)
        if self._maxflow is not None:
            exchanges += self._maxflow.exchanges
        for batch in self._triples:
            exchanges += batch.exchanges
        return exchanges


def _pair_subproblems(
    problem: LabellingProblem, side: Side, share: float, optional: bool
) -> PairSubproblems:
    """All pairs of points of a side that have pairwise costs, with a share of these."""
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


class _Across:
    """Pairwise costs go from the target pairs to the source pairs."""

    def __init__(self, source: PairSubproblems, target: PairSubproblems) -> None:
        self._source, self._target = source, target
        match = match_sparse if source.groups.listed else match_full
        there, self._back = match(source.side, source.groups, target.side, target.groups)
        self.exchange = Exchange(source.pairwise, target.pairwise, there)

    def turn(self) -> float:
        losses = self._back[self._target.used_pairwise]
        return self.exchange.turn(
            used_once(self._source.used_pairwise), used_once(losses), _MOMENTUM
        )


class _Unconstrained:
    """The maxflow subproblem gets unary costs from the linear one, pairwise ones from the pairs."""

    def __init__(
        self,
        problem: LabellingProblem,
        sides: list[PairSubproblems],
        linear: LinearSubproblem,
    ) -> None:
        base = sides[0] if sides else _pair_subproblems(problem, sides_of(problem)[0], 1.0, True)
        self._base = base if sides else None
        places = np.flatnonzero(np.isfinite(base.pairwise)).astype(np.int64)
        first, second = (ends[places] for ends in candidates_of(base.side, base.groups))
        unary = np.zeros(problem.n_candidates)
        # Every subproblem began with the same share.
        self.part = MaxflowSubproblem(first, second, unary, base.pairwise[places].copy())
        self.exchanges = [Exchange(unary, linear.unary, np.arange(len(unary)))]
        self._inverse = np.full(len(base.pairwise), NOTHING, dtype=np.int64)
        self._inverse[places] = np.arange(len(places))
        if sides:
            self.exchanges.append(Exchange(self.part.pairwise, base.pairwise, places))

    def turn(self, used: IntArray) -> float:
        norm = self.exchanges[0].turn(self.part.used_unary, used_once(used), _MOMENTUM)
        if self._base is not None:
            losses = used_once(self._inverse[self._base.used_pairwise])
            norm += self.exchanges[1].turn(self.part.used_pairwise, losses, _MOMENTUM)
        return norm


class _TripleBatches:
    """Triples of one side, as they were added: costs from the linear subproblem and the pairs."""

    def __init__(self, pairs: PairSubproblems, linear: LinearSubproblem) -> None:
        self._pairs, self._linear = pairs, linear
        self._taken = np.zeros(len(pairs.groups.points), dtype=np.bool_)
        self._batches: list[TripleSubproblems] = []
        self.exchanges: list[Exchange] = []

    def add(self, most: int) -> int:
        chosen = choose_triples(self._pairs, most, self._taken)
        if not len(chosen.points):
            return 0
        batch = TripleSubproblems(self._pairs, chosen)
        possible = np.where(np.isfinite(batch.pairwise), batch.place_at, NOTHING)
        self._batches.append(batch)
        self.exchanges += [
            Exchange(batch.unary, self._linear.unary, batch.candidate_at),
            Exchange(batch.pairwise, self._pairs.pairwise, possible),
        ]
        return len(chosen.points)

    def minimise(self) -> float:
        return sum(batch.minimise() for batch in self._batches)

    def turn(self, used: IntArray) -> float:
        norm = 0.0
        lost = self._pairs.used_pairwise
        for k, batch in enumerate(self._batches):
            unary, pairwise = batch.used
            of_unary, of_pairwise = self.exchanges[2 * k : 2 * k + 2]
            norm += of_unary.turn(unary, batch.unary_places_of(used), _MOMENTUM)
            norm += of_pairwise.turn(pairwise, batch.pairwise_places_of(lost), _MOMENTUM)
        return norm
