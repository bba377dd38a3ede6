"""A further hypothesis, carried through the levels among others."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.matching import (
    HierarchicalRun,
    Hypothesis,
    Level,
    MatchOptions,
    build_level,
    level_sizes,
)
from solver.shape import Shape
from tests.solver import shapes

OPTIONS = MatchOptions(points=32, metric=("geodesic",), descriptor=("hks",))


@pytest.fixture(scope="module")
def levels() -> list[Level]:
    """A shape against itself: source samples are the first of the target's."""
    blob = Shape(shapes.blob())
    sizes = level_sizes(blob, blob, OPTIONS)
    return [build_level(blob, blob, i, size, OPTIONS) for i, size in enumerate(sizes)]


@pytest.fixture(scope="module")
def run() -> HierarchicalRun:
    return HierarchicalRun(OPTIONS, Control())


@pytest.fixture(scope="module")
def others(run: HierarchicalRun, levels: list[Level]) -> list[Hypothesis]:
    return run.ranked(levels)


def near(level: Level, places: IntArray) -> FloatArray:
    """Distances from where samples were put, other samples of the target, to all of these."""
    return level.target.distances[places]


def test_what_is_put_in_place_stays_there_and_is_first(
    run: HierarchicalRun, levels: list[Level], others: list[Hypothesis]
) -> None:
    truth = np.arange(len(levels[0].source.vertices))
    found = run.carried(levels, near(levels[0], truth), others)
    np.testing.assert_array_equal(found.partners, np.arange(32))
    assert [stage.rank for stage in found.stages] == [1] * len(levels)
    assert found.energy == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("seed", [0, 1])
def test_what_is_out_of_place_is_ranked_among_the_others(
    run: HierarchicalRun, levels: list[Level], others: list[Hypothesis], seed: int
) -> None:
    """At every level the rank is the place in the order of energies there."""
    count = len(levels[0].source.vertices)
    places = np.random.default_rng(seed).permutation(count)
    found = run.carried(levels, near(levels[0], places), others)
    np.testing.assert_array_equal(found.stages[0].solution.answer, places)
    assert len(found.stages) == len(levels)
    for index, (level, stage) in enumerate(zip(levels, found.stages, strict=True)):
        energies = [other.stages[index].solution.value for other in others]
        assert stage.rank == 1 + np.searchsorted(np.sort(energies), stage.solution.value)
        assert stage.solution.value == pytest.approx(stage.problem.energy(stage.solution.answer))
        assert len(stage.solution.answer) == len(level.source.vertices)
    assert found.stages[0].rank == len(others) + 1


def test_the_coarse_bound_is_that_of_the_proven_optimum(
    run: HierarchicalRun, levels: list[Level], others: list[Hypothesis]
) -> None:
    """The problem is the same: what bounds one of its solutions bounds another."""
    places = np.arange(len(levels[0].source.vertices))[::-1].copy()
    coarse = run.carried(levels, near(levels[0], places), others).stages[0].solution
    assert coarse.lower_bound == others[0].stages[0].solution.lower_bound
    assert coarse.lower_bound <= min(one.stages[0].solution.value for one in others)
    assert coarse.lower_bound < coarse.value
