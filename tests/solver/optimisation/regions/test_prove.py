"""Proofs over all candidates: against plain enumeration, and what they leave open."""

import itertools
import time

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.control import Control, Status, iterate
from solver.errors import Cancelled
from solver.labelling import UNMATCHED, LabellingProblem
from solver.optimisation.primal import InfeasibleError, local_search
from solver.optimisation.regions import RegionSearch, can_prove, prove
from solver.optimisation.regions import region as region_module
from solver.optimisation.regions import search as region_search
from solver.optimisation.regions.branching import divide_region
from solver.optimisation.regions.message_passing import MetricCosts
from solver.optimisation.regions.region import ascend, whole_region
from tests.solver.problems import (
    REGIMES,
    all_solutions,
    distances_of,
    explicit_instance,
    metric_instance,
    relabelled,
)


@pytest.fixture
def without_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Divide regions down to single correspondences."""
    monkeypatch.setattr(region_search, "_SEARCH_LABELS", 0)


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 4), (3, 3), (4, 6), (5, 5)])
def test_optimum_is_that_of_enumeration(regime: str, n: int, m: int) -> None:
    for seed in range(4):
        problem = metric_instance(n, m, seed, **REGIMES[regime])
        found = prove(problem)
        assert found.value == pytest.approx(all_solutions(problem)[0][0], abs=1e-12)
        assert found.lower_bound == found.value
        assert problem.energy(found.answer) == pytest.approx(found.value)


@pytest.mark.usefixtures("without_search")
@pytest.mark.parametrize("regime", REGIMES)
def test_optimum_by_division_alone(regime: str) -> None:
    for seed in range(4):
        problem = metric_instance(4, 5, seed, **REGIMES[regime])
        found = prove(problem)
        assert found.value == pytest.approx(all_solutions(problem)[0][0], abs=1e-12)
        assert found.lower_bound == found.value


@pytest.mark.parametrize("regime", ["noisy", "occlusion", "few candidates"])
def test_dropped_labels_are_of_no_better_correspondence(regime: str) -> None:
    for seed in range(4):
        problem = metric_instance(4, 6, seed, **REGIMES[regime])
        solutions = all_solutions(problem)
        limit = solutions[len(solutions) // 8][0]
        whole = whole_region(problem)
        region, _ = ascend(problem, MetricCosts.of(problem, limit), whole, limit, np.inf, Control())
        assert region.bound <= solutions[0][0] + 1e-9
        left = set(zip(region.points.tolist(), region.labels.tolist(), strict=True))
        for energy, partners in solutions:
            chosen = problem.chosen_candidates(np.array(partners))
            used = set(enumerate(chosen.tolist()))
            if energy < limit:
                assert used <= left
            keys = zip(region.points.tolist(), region.labels.tolist(), strict=True)
            bounds = dict(zip(keys, region.bounds.tolist(), strict=True))
            assert all(bounds[each] <= energy + 1e-9 for each in used & left)


@pytest.mark.parametrize("regime", ["noisy", "occlusion", "few candidates"])
def test_parts_contain_every_correspondence_once(regime: str) -> None:
    problem = metric_instance(4, 6, 2, **REGIMES[regime])
    whole = whole_region(problem)
    parts = divide_region(problem, whole, 10.0)
    assert all(len(part.labels) < len(whole.labels) for part in parts)
    for _, partners in all_solutions(problem):
        used = set(enumerate(problem.chosen_candidates(np.array(partners)).tolist()))
        containing = [
            used <= set(zip(part.points.tolist(), part.labels.tolist(), strict=True))
            for part in parts
        ]
        assert sum(containing) == 1


def test_proof_of_many_candidates() -> None:
    problem = metric_instance(20, 60, 0, noise=0.15, unary=0.02)
    found = prove(problem)
    assert found.status is Status.CONVERGED
    assert found.gap == 0.0
    rng = np.random.default_rng(0)
    for _ in range(20):
        start = rng.permutation(60)[:20]
        assert problem.energy(local_search(problem, start)) >= found.value - 1e-9


def test_optimum_does_not_depend_on_the_numbering() -> None:
    problem = metric_instance(10, 30, 1, noise=0.4)
    rng = np.random.default_rng(0)
    again = relabelled(problem, rng.permutation(10), rng.permutation(30))
    assert prove(problem).value == pytest.approx(prove(again).value)


def test_the_best_start_is_a_beginning() -> None:
    problem = metric_instance(12, 30, 1, noise=0.3)
    best = prove(problem)
    again = prove(problem, [np.arange(12), best.answer])
    assert again.value == pytest.approx(best.value)
    assert again.iterations <= best.iterations


def test_each_target_point_is_used_once() -> None:
    crowded = metric_instance(6, 6, 0, noise=2.0, unary=0.0)
    found = prove(crowded)
    assert sorted(found.answer.tolist()) == list(range(6))


def test_samples_in_one_place_end() -> None:
    place = np.zeros((6, 6))
    problem = LabellingProblem(np.argwhere(np.ones((3, 6))), np.zeros(18), np.zeros((3, 3)), place)
    assert prove(problem).value == 0.0


def test_work_and_deadline_leave_a_valid_bound() -> None:
    problem = metric_instance(16, 48, 0, noise=0.5)
    known = prove(problem, seconds=20.0)
    optimum = known.value
    assert (known.status, known.gap) == (Status.CONVERGED, 0.0)
    for control, seconds, status in (
        (Control(), 0.01, Status.ITERATIONS),
        (Control(), 0.1, Status.ITERATIONS),
        (Control(deadline=time.monotonic()), 10.0, Status.DEADLINE),
    ):
        found = prove(problem, seconds=seconds, control=control)
        assert found.status is status
        assert found.gap > 0.0
        assert 0.0 <= found.lower_bound <= optimum + 1e-9
        assert found.value >= optimum - 1e-9
        assert problem.energy(found.answer) == pytest.approx(found.value)


@pytest.mark.parametrize("regime", ["noisy", "occlusion", "few candidates"])
def test_parts_of_a_round_change_nothing(monkeypatch: pytest.MonkeyPatch, regime: str) -> None:
    problem = metric_instance(5, 9, 3, **REGIMES[regime])
    arguments = problem, MetricCosts.of(problem, 2.0), whole_region(problem), 2.0, np.inf, Control()
    whole, _ = ascend(*arguments)
    monkeypatch.setattr(region_module, "_PAIRS_PER_PART", 1)
    in_parts, _ = ascend(*arguments)
    assert (in_parts.bound, in_parts.bounds.tolist()) == (whole.bound, whole.bounds.tolist())
    assert in_parts.messages.tolist() == whole.messages.tolist()


@pytest.mark.parametrize("parts", [1, 6, 12])
def test_a_round_ends_at_the_deadline_and_when_cancelled(
    monkeypatch: pytest.MonkeyPatch, parts: int
) -> None:
    monkeypatch.setattr(region_module, "_PAIRS_PER_PART", 1)
    problem = metric_instance(5, 9, 3)
    whole = whole_region(problem)
    arguments = problem, MetricCosts.of(problem, 2.0), whole, 2.0, np.inf
    asked = itertools.count()

    class Short(Control):
        @property
        def expired(self) -> bool:
            return next(asked) > parts

    assert ascend(*arguments, Short())[0] is whole
    asked = itertools.count()
    with pytest.raises(Cancelled):
        ascend(*arguments, Control(is_cancelled=lambda: next(asked) > parts))


def polygon(corners: int) -> FloatArray:
    angles = 2.0 * np.pi * np.arange(corners) / corners
    return distances_of(np.stack([np.cos(angles), np.sin(angles)], axis=1))


def simplex(corners: int) -> FloatArray:
    return 1.0 - np.eye(corners)


def all_pairs(source: FloatArray, target: FloatArray) -> LabellingProblem:
    pairs = np.argwhere(np.ones((len(source), len(target))))
    return LabellingProblem(pairs, np.zeros(len(pairs)), source, target)


PROBLEMS_OF_LITTLE_MEMORY = {
    "noise": metric_instance(12, 36, 2, noise=0.8),
    "equal bounds": all_pairs(polygon(5), polygon(7)),
    "equal distances": all_pairs(simplex(4), polygon(6)),
}


@pytest.mark.usefixtures("without_search")
@pytest.mark.parametrize("name", PROBLEMS_OF_LITTLE_MEMORY)
def test_search_ends_when_memory_is_short(name: str) -> None:
    problem = PROBLEMS_OF_LITTLE_MEMORY[name]
    optimum = prove(problem)
    assert optimum.gap == 0.0
    start = np.arange(problem.n_sources)
    search = RegionSearch(problem, [start], np.inf, Control(), memory=0)
    ended = iterate(search, 1000, Control())
    assert ended.status is Status.CONVERGED
    assert ended.state.lower_bound == pytest.approx(optimum.value)


@pytest.mark.usefixtures("without_search")
@pytest.mark.parametrize("name", PROBLEMS_OF_LITTLE_MEMORY)
@pytest.mark.parametrize("regions", [0, 1])
def test_messages_of_open_regions_but_the_first_are_within_the_memory(
    name: str, regions: int
) -> None:
    problem = PROBLEMS_OF_LITTLE_MEMORY[name]
    memory = 8 * regions * problem.n_sources * problem.n_candidates
    start = np.arange(problem.n_sources)
    search = RegionSearch(problem, [start], np.inf, Control(), memory)
    state, forgotten = search.init(), False
    while not search.done(state):
        state = search.step(state)
        forgotten |= state.regions > 0 and not all(region.is_divided for region in state.open)
        assert sum(region.messages.nbytes for region in state.open[1:]) <= memory
    assert forgotten


def test_cancellation() -> None:
    with pytest.raises(Cancelled):
        prove(metric_instance(8, 12, 0), control=Control(is_cancelled=lambda: True))


def test_the_bound_rises_from_step_to_step() -> None:
    problem = metric_instance(14, 42, 3, noise=0.8)
    search = RegionSearch(problem, [np.arange(14)], np.inf, Control())
    state, bound = search.init(), 0.0
    for _ in range(12):
        state = iterate(search, 1, Control(), state).state
        assert state.lower_bound >= bound - 1e-9
        bound = state.lower_bound


def test_problems_of_another_form_are_refused() -> None:
    assert not can_prove(explicit_instance(3, 3, 0))
    with pytest.raises(ValueError, match="distortions"):
        prove(explicit_instance(3, 3, 0))


def test_without_candidates_nothing_is_matched() -> None:
    nothing = np.zeros((0, 2), dtype=np.int64), np.zeros(0), np.eye(3), np.eye(3)
    found = prove(LabellingProblem(*nothing, occlusion_cost=0.5))
    assert (found.answer == UNMATCHED).all()
    assert found.value == found.lower_bound == pytest.approx(1.5)
    with pytest.raises(InfeasibleError):
        prove(LabellingProblem(*nothing))
