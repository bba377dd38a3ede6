"""The labelling problem (5) of section 2: candidates, costs, energy, distortion, solution."""

from solver.labelling.candidates import pairs_with_landmarks
from solver.labelling.distortion import Distortion, greatest_distortions, measure_distortion
from solver.labelling.objective import L2, LINF
from solver.labelling.pairwise import (
    NO_TABLE,
    PairwiseCosts,
    PairwiseTerms,
    distortion_cost,
    listed_cost,
    metric_cost,
    pairwise_cost,
    replace_costs,
)
from solver.labelling.problem import UNMATCHED, LabellingProblem
from solver.labelling.solution import CERTIFIED_GAP, Method, Solution, relative_gap
from solver.labelling.triples import (
    NO_TRIPLES,
    TripleCosts,
    add_triple_costs,
    cost_given_third,
    costs_of_triples,
    replace_triple_costs,
    triple_cost,
    triple_costs,
)

__all__ = [
    "CERTIFIED_GAP",
    "L2",
    "LINF",
    "NO_TABLE",
    "NO_TRIPLES",
    "UNMATCHED",
    "Distortion",
    "LabellingProblem",
    "Method",
    "PairwiseCosts",
    "PairwiseTerms",
    "Solution",
    "TripleCosts",
    "add_triple_costs",
    "cost_given_third",
    "costs_of_triples",
    "distortion_cost",
    "greatest_distortions",
    "listed_cost",
    "measure_distortion",
    "metric_cost",
    "pairs_with_landmarks",
    "pairwise_cost",
    "relative_gap",
    "replace_costs",
    "replace_triple_costs",
    "triple_cost",
    "triple_costs",
]
