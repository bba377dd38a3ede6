"""A further hypothesis, begun at a map and refined through the levels."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.labelling import UNMATCHED
from solver.matching import (
    Hypothesis,
    Level,
    MatchOptions,
    build_level,
    certify,
    drop_duplicates,
    enumerate_hypotheses,
    hypothesis_from_map,
    level_sizes,
    refine_hypotheses,
    report_match,
)
from solver.shape import Shape
from tests.solver import shapes

OPTIONS = MatchOptions(points=32, metric=("geodesic",), descriptor=("hks",))


@pytest.fixture(scope="module")
def levels() -> list[Level]:
    """A shape against itself: source samples are the first of the target's."""
    blob = Shape(shapes.blob())
    sizes = level_sizes(blob.n_vertices, blob.n_vertices, OPTIONS)
    return [build_level(blob, blob, i, size, OPTIONS) for i, size in enumerate(sizes)]


@pytest.fixture(scope="module")
def others(levels: list[Level]) -> list[Hypothesis]:
    hypotheses, warnings = enumerate_hypotheses(levels[0], OPTIONS, Control())
    assert not warnings
    return refine_hypotheses(hypotheses, levels[1:], OPTIONS.rho, Control())


def begun(levels: list[Level], places: IntArray, others: list[Hypothesis]) -> Hypothesis:
    return hypothesis_from_map(levels, near(levels[0], places), others, OPTIONS.rho, Control())


def near(level: Level, places: IntArray) -> FloatArray:
    """Distances from the images of samples, themselves target samples, to all of these."""
    return level.target.distances[places]


def ranks(hypotheses: list[Hypothesis], levels: list[Level]) -> list[int]:
    """Ranks of the first one, as they are reported."""
    ids = np.arange(shapes.blob().n_vertices)
    report = report_match(hypotheses, levels, (ids, ids), (), Control())
    return [level.rank for level in report.levels]


def test_past_the_deadline_the_first_hypothesis_alone_is_refined(levels: list[Level]) -> None:
    hypotheses, _ = enumerate_hypotheses(levels[0], OPTIONS, Control())
    late = Control().within(0.0)
    (found,) = refine_hypotheses(hypotheses, levels[1:], OPTIONS.rho, late)
    (alone,) = refine_hypotheses(hypotheses[:1], levels[1:], OPTIONS.rho, Control())
    np.testing.assert_array_equal(found.partners, alone.partners)
    assert found.energy == alone.energy
    assert len(hypotheses) > 1


def test_hypotheses_that_become_equal_are_refined_once(
    levels: list[Level], others: list[Hypothesis]
) -> None:
    coarse = [Hypothesis(one.levels[:1]) for one in others]
    found = refine_hypotheses([*coarse, *coarse], levels[1:], OPTIONS.rho, Control())
    assert [one.energy for one in found] == [one.energy for one in others]
    assert len(drop_duplicates(found)) == len(found)


def test_past_the_deadline_no_level_is_bounded(
    levels: list[Level], others: list[Hypothesis]
) -> None:
    found = certify(others[1], levels, Control().within(0.0))
    assert found.levels == others[1].levels


def test_a_correct_map_is_kept_and_ranked_first(
    levels: list[Level], others: list[Hypothesis]
) -> None:
    truth = np.arange(len(levels[0].source.vertices))
    found = begun(levels, truth, others)
    np.testing.assert_array_equal(found.partners, np.arange(32))
    assert ranks([found, *others], levels) == [1] * len(levels)
    assert found.energy == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_wrong_map_is_ranked_among_the_others(
    levels: list[Level], others: list[Hypothesis], seed: int
) -> None:
    """At every level the rank is the place in the order of energies there."""
    count = len(levels[0].source.vertices)
    places = np.random.default_rng(seed).permutation(count)
    found = begun(levels, places, others)
    np.testing.assert_array_equal(found.levels[0].solution.answer, places)
    assert len(found.levels) == len(levels)
    distinct, ranked = drop_duplicates([found, *others]), ranks([found, *others], levels)
    for index, (level, stage) in enumerate(zip(levels, found.levels, strict=True)):
        energies = [other.levels[index].solution.value for other in distinct]
        assert ranked[index] == 1 + np.searchsorted(np.sort(energies), stage.solution.value)
        assert stage.solution.value == pytest.approx(stage.problem.energy(stage.solution.answer))
        assert len(stage.solution.answer) == len(level.source.vertices)
    assert ranked[0] == len(distinct)


def test_an_answer_that_a_bound_has_improved_is_ranked_anew(
    levels: list[Level], others: list[Hypothesis]
) -> None:
    """Certification improves the answer alone, which may overtake the others."""
    places = np.random.default_rng(0).permutation(len(levels[0].source.vertices))
    found = begun(levels, places, others)
    assert ranks([found, *others], levels)[-1] > 1
    improved = found.with_finest(others[0].levels[-1])
    assert ranks([improved, *others], levels)[-1] == 1


def test_the_coarse_bound_is_that_of_the_proven_optimum(
    levels: list[Level], others: list[Hypothesis]
) -> None:
    """The problem is the same: what bounds one of its solutions bounds another."""
    places = np.arange(len(levels[0].source.vertices))[::-1].copy()
    coarse = begun(levels, places, others).levels[0].solution
    assert coarse.lower_bound == others[0].levels[0].solution.lower_bound
    assert coarse.lower_bound <= min(one.levels[0].solution.value for one in others)
    assert coarse.lower_bound < coarse.value


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_occlusion_is_compared_with_energies_not_with_lengths(
    levels: list[Level], others: list[Hypothesis], unit: float
) -> None:
    truth = np.arange(len(levels[0].source.vertices))
    cheap = [replace(level, occlusion_cost=0.05) for level in levels]
    # The images are not samples: each lies nearest its own one.
    distances = unit * (near(levels[0], truth) + 0.1)
    found = hypothesis_from_map(cheap, distances, others, OPTIONS.rho, Control())
    np.testing.assert_array_equal(found.levels[0].solution.answer, truth)
    assert found.energy == pytest.approx(0.0, abs=1e-9)


def test_points_of_a_wrong_map_stay_unmatched_where_that_costs_less(
    levels: list[Level], others: list[Hypothesis]
) -> None:
    places = np.arange(len(levels[0].source.vertices))[::-1].copy()
    cheap = [replace(levels[0], occlusion_cost=0.01)]
    found = hypothesis_from_map(cheap, near(levels[0], places), others, OPTIONS.rho, Control())
    kept = found.partners != UNMATCHED
    np.testing.assert_array_equal(found.partners[kept], places[kept])
    assert found.energy <= 0.01 * len(places)
