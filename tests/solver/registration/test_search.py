"""Search: which candidate stands after more have been tried."""

import numpy as np

from solver.functional_maps import FunctionalMap
from solver.registration.alignment import Alignment, Pairs
from solver.registration.choice import Candidate
from solver.registration.fit import Fit, LocalFit
from solver.registration.search import unless_it_is_close

NOTHING = Alignment(np.zeros((1, 3)), FunctionalMap(np.eye(1)), np.eye(3))
POSITIONS = np.array([[0.0, 0, 0], [0.01, 0, 0], [1.0, 0, 0]])


def candidate(images: list[int], score: float) -> Candidate:
    fit = Fit(float(np.exp(score)), 1.0, 1.0, 1.0, (1.0,), 1.0)
    everywhere = np.arange(len(images))
    local = LocalFit(np.ones((5, len(images))), Pairs(everywhere, everywhere))
    return Candidate(np.array(images), NOTHING, fit, local)


def test_a_known_candidate_stands_unless_another_is_clearly_better() -> None:
    known = candidate([0, 2], -1.0)
    slightly, clearly = candidate([2, 0], -1.1), candidate([2, 0], -2.0)
    assert unless_it_is_close(known, [slightly, known], POSITIONS) == [known, slightly]
    assert unless_it_is_close(known, [clearly, known], POSITIONS) == [clearly, known]


def test_one_that_is_the_same_and_fits_better_stands_for_the_known_one() -> None:
    known, same, rival = candidate([0, 2], -1.0), candidate([1, 2], -1.5), candidate([2, 0], -1.2)
    assert unless_it_is_close(known, [same, rival], POSITIONS) == [same, rival]
    better = candidate([2, 0], -1.6)
    assert unless_it_is_close(known, [better, same], POSITIONS) == [same, better]
