"""Branch and bound: the m best solutions of small labelling problems, with a proof.

Before the search, a few rounds of dual ascent move costs from pairs of points to the points, greedy
completions and local changes provide incumbents, and candidates are dropped that no better
correspondence uses. What is left is searched depth first.

Instead of the dual ascent's, the reparametrised costs of a dual decomposition can be given: their
constant part is greater, so that the search prunes earlier.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from solver.arrays import FloatArray, IntArray
from solver.control import Control, Status, iterate
from solver.labelling import LabellingProblem, Method, Solution
from solver.optimisation.exact.depth_first import NODES_PER_STEP, DepthFirstSearch
from solver.optimisation.exact.dual_ascent import DualAscent
from solver.optimisation.exact.incumbents import Incumbents, dive, energy_of, keep
from solver.optimisation.exact.search_state import NODES, root_bound, start_search
from solver.optimisation.exact.triple_division import divide_triples
from solver.optimisation.primal import partners_of
from solver.optimisation.reparametrisation import ReparametrisedCosts

FEW_POINTS = 16
"""Source points up to which a problem counts as small: every candidate is completed greedily if
few were dropped."""
_MANY_KEPT = 0.5
"""Share of the candidates above which few count as dropped."""


@dataclass(frozen=True, eq=False)
class Enumeration:
    """The best solutions of a labelling problem, a sequence of :class:`Solution`, best first.

    Parameters
    ----------
    partners
        (m, N) target point of each source point, `UNMATCHED` for none. Fewer rows than asked for
        when the problem has fewer solutions.
    energies
        (m,) their energies, ascending.
    lower_bound
        A lower bound of the least energy.
    nodes
        Search nodes visited.
    status
        ``CONVERGED`` when the search was exhaustive.
    candidates
        (V',) ascending: all candidates of correspondences that are better than the last one found.
    """

    partners: IntArray
    energies: FloatArray
    lower_bound: float
    nodes: int
    status: Status
    candidates: IntArray

    @property
    def proven(self) -> bool:
        """Whether no solution outside the list is better than its last."""
        return self.status is Status.CONVERGED

    @classmethod
    def empty(cls, problem: LabellingProblem) -> "Enumeration":
        """Return that of a problem without solutions."""
        partners = np.empty((0, problem.n_sources), dtype=np.int64)
        none = np.empty(0, dtype=np.int64)
        return cls(partners, np.empty(0), np.inf, 0, Status.CONVERGED, none)

    def __len__(self) -> int:
        return len(self.energies)

    def __getitem__(self, index: int) -> Solution[IntArray]:
        return Solution(
            self.partners[index],
            float(self.energies[index]),
            self.lower_bound,
            self.nodes,
            Method.BRANCH_AND_BOUND,
            self.status,
        )

    def __iter__(self) -> Iterator[Solution[IntArray]]:
        return (self[index] for index in range(len(self)))


def m_best_solutions(
    problem: LabellingProblem,
    m: int = 1,
    *,
    known: IntArray | None = None,
    reparametrised: ReparametrisedCosts | None = None,
    rounds: int = 1,
    node_limit: int = 50_000_000,
    control: Control | None = None,
) -> Enumeration:
    """Enumerate the m solutions of least energy.

    Parameters
    ----------
    problem
        A small problem; time grows exponentially with its number of source points. Twelve are
        quick, sixteen usually are. Memory is some 32 bytes times the square of its number of
        candidates.
    m
        Number of solutions.
    known
        (N,) a correspondence of the problem; its energy prunes the search.
    reparametrised
        Costs for lower bounds; by default those of a dual ascent.
    rounds
        Rounds of the ascent, at least 1; more pay off where there are many source points.
    node_limit
        Search nodes, in rounds of at most 20,000, after which the best solutions so far are
        returned, not proven.
    control
        Cancels the search, or ends it at a deadline as the node limit does.

    Returns
    -------
    Enumeration

    Raises
    ------
    Cancelled
        Through `control`.
    ValueError
        `m` is not positive.

    Examples
    --------
    A triangle and its mirror image: the best of the six bijections distorts nothing.

    >>> import numpy as np
    >>> from solver.labelling import LabellingProblem
    >>> source = np.array([[0.0, 3.0, 4.0], [3.0, 0.0, 5.0], [4.0, 5.0, 0.0]])
    >>> target = np.ascontiguousarray(source[::-1, ::-1])
    >>> pairs = np.argwhere(np.ones((3, 3)))
    >>> found = m_best_solutions(LabellingProblem(pairs, np.zeros(9), source, target), 2)
    >>> found.partners.tolist(), found.energies.tolist(), found.proven
    ([[2, 1, 0], [1, 2, 0]], [0.0, 2.0], True)
    """
    if m < 1:
        raise ValueError("m must be at least 1")
    control = control or Control()
    control.check()
    if not _has_solutions(problem):
        return Enumeration.empty(problem)
    own = ReparametrisedCosts.of(problem)
    best = _incumbents(problem, own, m, known)
    kept = np.arange(problem.n_candidates)
    if reparametrised is None and not control.expired:
        kept, reparametrised = _ascend(problem, own, best, rounds, control)
    reparametrised = divide_triples(reparametrised or own)
    promising = _promising(problem, own, reparametrised, kept, best, complete=known is None)
    kept, reparametrised = kept[promising], reparametrised.among(promising)
    search = start_search(own, reparametrised, problem.candidates[kept, 0], kept, best)
    root = max(root_bound(search), 0.0 if problem.non_negative else -np.inf)
    each = max(NODES_PER_STEP // (1 + len(problem.triples.points)), 1)
    ended = iterate(DepthFirstSearch(search, each), -(-node_limit // each), control)
    found = np.isfinite(best.energies)
    partners = np.stack([partners_of(problem, row) for row in best.chosen])[found]
    energies = best.energies[found]
    least = float(energies.min(initial=np.inf))
    bound = least if ended.status is Status.CONVERGED else min(root, least)
    nodes = int(search.counters[NODES])
    return Enumeration(partners, energies, bound, nodes, ended.status, kept)


def _has_solutions(problem: LabellingProblem) -> bool:
    """Whether all points have partners of their own, or may be left unmatched.

    A search needs exponential time to find out; a maximum matching tells at once.
    """
    if not problem.must_match_all:
        return True
    sources, targets = problem.candidates.T
    shape = problem.n_sources, int(targets.max(initial=0)) + 1
    graph = csr_array((np.ones(len(sources), dtype=np.int8), (sources, targets)), shape=shape)
    return bool((maximum_bipartite_matching(graph, perm_type="column") >= 0).all())


def _incumbents(
    problem: LabellingProblem, own: ReparametrisedCosts, m: int, known: IntArray | None
) -> Incumbents:
    """Room for m correspondences, with the known one."""
    best = Incumbents.none(m, problem.n_sources)
    if known is not None:
        chosen = problem.chosen_candidates(known)
        keep(best, energy_of(own, chosen), chosen)
    return best


def _ascend(
    problem: LabellingProblem,
    own: ReparametrisedCosts,
    best: Incumbents,
    rounds: int,
    control: Control,
) -> tuple[IntArray, ReparametrisedCosts]:
    """Rounds of dual ascent; after the first one, incumbents are looked for.

    Returns
    -------
    The candidates that are left, and their reparametrised costs. Costs of triples are moved to
    their pairs before the rounds, and once more between two times as many.
    """
    rows, costs = problem.first_candidate, divide_triples(own)
    state = iterate(DualAscent(costs, rows), 1, control).state
    dive(best, own, state.costs(), rows)
    dive(best, own, own, rows)
    limit = float(best.energies[-1])
    state = iterate(DualAscent(costs, rows, limit), rounds - 1, control, state).state
    kept, costs = state.kept, state.costs()
    if len(own.triples.points) and len(kept):
        rows = np.searchsorted(problem.candidates[kept, 0], np.arange(problem.n_sources + 1))
        state = iterate(DualAscent(divide_triples(costs), rows, limit), rounds, control).state
        kept, costs = kept[state.kept], state.costs()
    return kept, costs


def _promising(
    problem: LabellingProblem,
    own: ReparametrisedCosts,
    reparametrised: ReparametrisedCosts,
    kept: IntArray,
    best: Incumbents,
    *,
    complete: bool,
) -> IntArray:
    """Places among those kept of candidates that a correspondence better than the m-th may use."""
    rows = np.searchsorted(problem.candidates[kept, 0], np.arange(problem.n_sources + 1))
    found = reparametrised.promising(rows, float(best.energies[-1]))
    few = problem.n_sources <= FEW_POINTS
    if complete and few and len(found) > _MANY_KEPT * len(kept):
        dive(best, own, own, problem.first_candidate, everywhere=True)
        found = reparametrised.promising(rows, float(best.energies[-1]))
    return found
