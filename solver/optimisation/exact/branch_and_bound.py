"""Exact optimum, and the m best solutions, of small labelling problems.

Before the search a few rounds of dual ascent divide the costs so that points cost as much as
possible on their own, good correspondences are looked for, and candidates are dropped that none
better than these can use. What is left is searched depth first.

The costs that bound can also be given: a dual decomposition turns them into costs of the same
solutions whose greater part is a constant, and with these the search prunes earlier still.
"""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import LabellingProblem
from solver.optimisation.exact.depth_first import advance
from solver.optimisation.exact.dual_ascent import DualAscent
from solver.optimisation.exact.incumbents import Incumbents, dive, energy_of, keep
from solver.optimisation.exact.search_state import NODES, root_bound, start_search
from solver.optimisation.primal import partners_of
from solver.optimisation.reparametrisation import BoundingCosts

_NODES_PER_CALL = 20_000
_FEW_POINTS = 16
"""Up to so many source points, better answers are looked for if the first drop no candidates."""


@dataclass(frozen=True, eq=False)
class ExactSolutions:
    """The best solutions of a labelling problem.

    Parameters
    ----------
    partners
        (m, N) target point of each source point, `UNMATCHED` for none; best first. Fewer rows
        than asked for when the problem has fewer solutions.
    energies
        (m,) their energies, ascending.
    proven
        Whether the search was exhaustive: no solution outside the list is better than its last.
    nodes
        Search nodes visited.
    lower_bound
        No correspondence costs less.
    candidates
        (V',) ascending: what any correspondence uses that is better than the last one found.
    """

    partners: IntArray
    energies: FloatArray
    proven: bool
    nodes: int
    lower_bound: float
    candidates: IntArray


def m_best_solutions(
    problem: LabellingProblem,
    m: int = 1,
    *,
    known: IntArray | None = None,
    bounding: BoundingCosts | None = None,
    rounds: int = 1,
    node_limit: int = 50_000_000,
    control: Control | None = None,
) -> ExactSolutions:
    """Enumerate the m solutions of least energy.

    Parameters
    ----------
    problem
        A small problem; time grows exponentially with its number of source points. Twelve are
        quick, sixteen usually are. Memory is some 32 bytes times the square of its number of
        candidates.
    m
        How many solutions.
    known
        (N,) a correspondence of the problem; nothing worse is looked at when m is 1.
    bounding
        Costs to prune with; by default those of a dual ascent.
    rounds
        Of the ascent, at least 1; more are of use where there are many source points.
    node_limit
        Search nodes after which the search gives up; the best found are then returned with
        ``proven`` false.
    control
        Cancels the search, or ends it at a deadline as the node limit does.

    Returns
    -------
    ExactSolutions

    Raises
    ------
    Cancelled
        Through `control`.
    ValueError
        `m` is not positive.
    """
    if m < 1:
        raise ValueError("m must be at least 1")
    control = control or Control()
    control.check()
    own, rows = BoundingCosts.of(problem), problem.first_candidate
    best = Incumbents.none(m, problem.n_sources)
    if known is not None:
        chosen = problem.chosen_candidates(known)
        keep(best, energy_of(own.unary, own.pairwise, own.occlusion, chosen), chosen)
    kept = np.arange(problem.n_candidates)
    if bounding is None and control.seconds_left() > 0.0:
        ascent = DualAscent(own, rows)
        ascent.run(1)
        dive(best, own, ascent.costs(), rows)
        dive(best, own, own, rows)
        ascent.run(rounds - 1, float(best.energies[-1]))
        kept, bounding = ascent.kept, ascent.costs()
    bounding = bounding or own
    of_kept = np.searchsorted(problem.candidates[kept, 0], np.arange(problem.n_sources + 1))
    promising = bounding.promising(of_kept, float(best.energies[-1]))
    if known is None and len(promising) > 0.5 * len(kept) and problem.n_sources <= _FEW_POINTS:
        dive(best, own, own, rows, everywhere=True)
        promising = bounding.promising(of_kept, float(best.energies[-1]))
    kept, bounding = kept[promising], bounding.among(promising)
    search = start_search(own, bounding, problem.candidates[kept, 0], kept, best)
    bound = root_bound(search)
    done = False
    while not done and search.counters[NODES] < node_limit and control.seconds_left() > 0.0:
        control.check()
        done = advance(search, _NODES_PER_CALL)
    found = np.isfinite(best.energies)
    partners = np.stack([partners_of(problem, row) for row in best.chosen])[found]
    energies = best.energies[found]
    least = float(energies[0]) if len(energies) else np.inf
    bound = least if done else min(bound, least)
    nodes = int(search.counters[NODES])
    return ExactSolutions(partners, energies, done, nodes, bound, kept)
