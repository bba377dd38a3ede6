"""Hypotheses of the coarsest level, and what is known of its optimum."""

import numpy as np
import pytest

from solver.control import Control, Status
from solver.matching import (
    Hypothesis,
    Level,
    MatchOptions,
    SampledStructure,
    build_level,
    enumerate_hypotheses,
    enumeration,
    hypothesis_from_map,
    refine_hypotheses,
    report_match,
)
from solver.shape import Shape
from solver.shape.choices import Geodesic, NoDescriptor
from tests.solver import shapes
from tests.solver.problems import distances_of

OPTIONS = MatchOptions(points=12, coarse_points=6, first_order_weight=0.5).settled(1.0)


def levels(target: Shape) -> list[Level]:
    source = Shape(shapes.blob())
    return [build_level(source, target, i, (6 * (i + 1), 12), OPTIONS) for i in range(2)]


@pytest.fixture(scope="module")
def with_itself() -> list[Level]:
    return levels(Shape(shapes.blob()))


def test_a_search_that_is_cut_short_has_a_bound() -> None:
    level = levels(Shape(shapes.blob(4)))[0]
    (optimum, *_), no_warnings = enumerate_hypotheses(level, OPTIONS, Control())
    cut, warnings = enumerate_hypotheses(level, OPTIONS, Control().within(0.0))
    assert not no_warnings
    assert len(warnings) == 1
    for one in cut:
        assert 0.0 < one.levels[0].solution.lower_bound <= optimum.energy <= one.energy
        assert not one.levels[0].solution.certified


def minimax_level(n: int) -> Level:
    """Random points, so that correspondences of little energy distort some distance most."""
    random = np.random.default_rng(0)
    metrics = (distances_of(random.normal(size=(n, 3))) for _ in range(2))
    ours, theirs = (SampledStructure(np.arange(n), metric, None) for metric in metrics)
    return Level(0, Geodesic(), NoDescriptor(), ours, theirs, 1.0, 0.0, np.inf)


def test_an_unproven_distortion_is_the_least_of_those_found() -> None:
    level = minimax_level(10)
    options = MatchOptions(points=10, objective="linf", proof_work=1e-6).settled(1.0)
    found, warnings = enumerate_hypotheses(level, options, Control())
    assert len(warnings) == 1
    distortions = [level.distortion(one.partners).linf for one in found]
    assert distortions == [one.energy for one in found] == sorted(distortions)
    assert len(set(distortions)) > 1
    for one in found:
        assert not one.levels[0].solution.certified
        assert one.levels[0].solution.status is Status.ITERATIONS


def test_optima_of_less_energy_are_said_to_be_possible(monkeypatch: pytest.MonkeyPatch) -> None:
    level = minimax_level(8)
    options = MatchOptions(points=8, objective="linf").settled(1.0)
    assert not enumerate_hypotheses(level, options, Control())[1]
    monkeypatch.setattr(enumeration, "_FURTHER_NODES", 0)
    found, warnings = enumerate_hypotheses(level, options, Control())
    assert found[0].levels[0].solution.certified
    assert "least energy" in warnings[0]


@pytest.mark.parametrize("begun_at_a_map", [False, True])
def test_the_coarsest_level_is_reported_with_its_optimum(
    with_itself: list[Level], begun_at_a_map: bool
) -> None:
    """It is 0 for a shape and itself, whichever hypothesis is chosen."""
    control = Control()
    found, _ = enumerate_hypotheses(with_itself[0], OPTIONS, control)
    another = next(one for one in found if one.energy > 0.1)
    refined = refine_hypotheses([another], with_itself[1:], OPTIONS.rho, control)
    chosen = refined[0]
    if begun_at_a_map:
        distances = with_itself[0].target.distances[np.arange(6)[::-1]]
        chosen = hypothesis_from_map(with_itself, distances, refined, OPTIONS.rho, control)
        assert chosen.levels[0].solution.value > 0.1
    assert coarsest(chosen, with_itself) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_the_coarsest_level_is_reported_with_its_answer_if_cut_short(
    with_itself: list[Level],
) -> None:
    control = Control().within(0.0)
    found, _ = enumerate_hypotheses(with_itself[0], OPTIONS, control)
    chosen = refine_hypotheses(found[-1:], with_itself[1:], OPTIONS.rho, control)[0]
    energy, bound = coarsest(chosen, with_itself)
    assert energy == chosen.levels[0].solution.value
    assert bound < energy


def coarsest(chosen: Hypothesis, levels: list[Level]) -> tuple[float, float]:
    """Energy and bound that are reported of the coarsest level."""
    ids = np.arange(shapes.blob().n_vertices)
    report = report_match([chosen], levels, (ids, ids), (), Control()).levels[0]
    return report.energy, report.lower_bound
