"""Search: refined candidates, and which one stands after more have been tried."""

import numpy as np

from solver.control import Control
from solver.functional_maps import FunctionalMap
from solver.mesh import triangle_mesh
from solver.registration.alignment import Alignment, Pairs
from solver.registration.candidates import pairs_from_points
from solver.registration.choice import COARSE, FINE, Candidate, Task, choose
from solver.registration.fit import Fit, LocalFit
from solver.registration.registration import NO_LANDMARKS
from solver.registration.search import refine_candidate, unless_it_is_close
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from synthetic import correspondence, human

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


def test_a_refined_candidate_is_nearer_to_the_truth_and_fits_better() -> None:
    """Begun at points that are off by more than a tenth of √area."""
    figures = human("standing", resolution=1000, seed=1), human("walking", resolution=1000, seed=2)
    source, target = (
        smooth_surface(Shape(triangle_mesh(one.vertices, one.faces))) for one in figures
    )
    truth, rest = correspondence(*figures), figures[1].rest
    task = Task(source, target, (source.samples, target.samples), NO_LANDMARKS)
    points = source.samples.vertices[:12]
    rng = np.random.default_rng(0)
    shifted = rest[truth[points]] + rng.normal(scale=0.1, size=(12, 3))
    near = np.linalg.norm(rest - shifted[:, None], axis=2).argmin(axis=1)

    def error(candidate: Candidate) -> float:
        samples = source.samples.first(len(candidate.images)).vertices
        return float(np.linalg.norm(rest[candidate.images] - rest[truth[samples]], axis=1).mean())

    rough, *_ = choose(
        task,
        lambda samples: [pairs_from_points((source, target), samples, (points, near))],
        (*COARSE, *FINE),
        Control(),
    )
    refined = refine_candidate(task, rough, Control())
    assert error(refined) < error(rough)
    assert refined.fit.score < rough.fit.score
