"""Correspondences of a region by the costs of its dual ascent: exact search, and assignment."""

import numpy as np

from solver.arrays import IntArray
from solver.control import Control, Status, iterate
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.exact import (
    NODES,
    NODES_PER_STEP,
    DepthFirstSearch,
    Incumbents,
    divided_costs,
    start_search,
)
from solver.optimisation.primal import Incumbent, partners_of, solve_lap
from solver.optimisation.regions.region import Region
from solver.optimisation.reparametrisation import ReparametrisedCosts


def search_region(
    problem: LabellingProblem, region: Region, incumbent: Incumbent, nodes: int, control: Control
) -> tuple[Incumbent, bool, int]:
    """Search a region depth first for a correspondence better than the incumbent.

    Parameters
    ----------
    problem
        The labelling problem.
    region
        A region of few labels; memory is some 32 bytes times the square of their number.
    incumbent
        The best correspondence known.
    nodes
        Limit on the search nodes, at least 1.
    control
        Cancels the search, or ends it at a deadline as the limit on the nodes does.

    Returns
    -------
    The best correspondence known; whether the region has no better one; search nodes visited.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    matched = region.labels != UNMATCHED
    part = problem.among(region.labels[matched])
    own = ReparametrisedCosts.of(part)
    best = Incumbents.none(1, problem.n_sources)
    best.energies[0] = incumbent.energy
    kept = np.arange(part.n_candidates)
    labels = np.full(len(region.labels), UNMATCHED)
    labels[matched] = kept
    unary = region.unary(problem)
    costs = divided_costs(own, region.points, labels, unary, region.messages)
    search = start_search(own, costs, region.points[matched], kept, best)
    each = min(nodes, NODES_PER_STEP)
    ended = iterate(DepthFirstSearch(search, each), -(-nodes // each), control)
    if best.energies[0] < incumbent.energy:
        incumbent = Incumbent.of(problem, partners_of(part, best.chosen[0]))
    return incumbent, ended.status is Status.CONVERGED, int(search.counters[NODES])


def assign_labels(problem: LabellingProblem, region: Region) -> IntArray:
    """Return the assignment of least cost in a region, as its dual ascent has divided the costs.

    Parameters
    ----------
    problem
        The labelling problem.
    region
        A region.

    Returns
    -------
    (N,) target point of each source point; outside the region where that allows no assignment.

    Raises
    ------
    InfeasibleError
        Every source point must be matched, and the candidates do not allow it.
    """
    matched = region.labels != UNMATCHED
    unary = region.unary(problem)[matched]
    outside = 2.0 * float(np.abs(unary).sum()) or 1.0
    costs = np.full(problem.n_candidates, outside)
    costs[region.labels[matched]] = unary
    return solve_lap(problem, costs)
