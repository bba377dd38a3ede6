"""Levels and the way a correspondence is refined from one to the next (4.1)."""

from dataclasses import replace

import numpy as np
import pytest

from solver.labelling import UNMATCHED
from solver.matching import Level, MatchOptions, SampledStructure, build_level, level_sizes, refine
from solver.shape import Shape
from solver.shape.choices import descriptor_choice, metric_choice
from tests.solver import shapes
from tests.solver.problems import distances_of

OPTIONS = MatchOptions(points=32, metric=("geodesic",), descriptor=("hks",))


@pytest.fixture(scope="module")
def blob() -> Shape:
    return Shape(shapes.blob())


@pytest.fixture(scope="module")
def levels(blob: Shape) -> list[Level]:
    """A shape against itself, so that the truth is equality of vertices."""
    sizes = level_sizes(blob.n_vertices, blob.n_vertices, OPTIONS)
    return [build_level(blob, blob, i, size, OPTIONS) for i, size in enumerate(sizes)]


def test_levels_grow_by_the_factor_up_to_the_points_asked_for(blob: Shape) -> None:
    count = blob.n_vertices, blob.n_vertices
    sizes = level_sizes(*count, MatchOptions(points=50, coarse_points=6, level_factor=3))
    assert sizes == [(6, 9), (18, 72), (50, 200)]
    assert level_sizes(*count, MatchOptions(points=5)) == [(5, 8)]


def test_levels_have_no_more_points_than_the_shapes() -> None:
    assert level_sizes(42, 42, MatchOptions(points=64)) == [
        (8, 12),
        (16, 42),
        (32, 42),
        (42, 42),
    ]


def test_targets_do_not_fall_from_level_to_level() -> None:
    options = MatchOptions(points=20, oversampling=1)
    assert level_sizes(642, 642, options) == [(8, 12), (16, 16), (20, 20)]
    assert level_sizes(642, 642, replace(options, points=9)) == [(8, 12), (9, 12)]


def test_the_energy_scales_as_documented(levels: list[Level]) -> None:
    """β·2/(N−1) times squared distances in units of their root mean square."""
    level = levels[1]
    problem = level.problem(level.all_candidates())
    assert problem.beta == pytest.approx(2.0 / 15)
    n = problem.n_sources
    both = np.stack([problem.source_distances, problem.target_distances[:n, :n]])
    assert (both**2).sum() == pytest.approx(2 * n * (n - 1))


def test_scale_is_not_normalised_away() -> None:
    """Shapes of different size in absolute units distort each other's geodesics."""
    one = Shape(shapes.blob(), normalise=False)
    two = Shape(shapes.moved(shapes.blob(), seed=0, scale=1.5), normalise=False)
    same = build_level(one, one, 0, (6, 6), OPTIONS).distortion(np.arange(6))
    larger = build_level(one, two, 0, (6, 6), OPTIONS).distortion(np.arange(6))
    assert same.linf == pytest.approx(0.0, abs=1e-12)
    assert larger.linf == pytest.approx(0.5 * one.sampling("geodesic", 6).distances.max(), rel=0.05)


def test_truth_at_a_coarse_level_becomes_truth_at_the_finer_one(levels: list[Level]) -> None:
    truth = np.arange(8)
    for level in levels[1:]:
        found = refine(truth, level, rho=1.5)
        assert found.energy == pytest.approx(0.0, abs=1e-12)
        assert (found.partners == np.arange(len(found.partners))).all()
        truth = found.partners


def test_candidates_lie_near_a_matched_pair_on_both_shapes(levels: list[Level]) -> None:
    """V_{k+1} of 4.1, with the radii that cover this level's samples."""
    rho, level, coarse = 1.3, levels[2], np.arange(16)
    found = refine(coarse, level, rho)
    to_source = level.source.distances[:, coarse]
    to_target = level.target.distances[:, coarse]
    reach_source = rho * to_source.min(axis=1).max()
    reach_target = rho * to_target.min(axis=1).max()
    x, y = found.problem.candidates.T
    near = (to_source[x] < reach_source) & (to_target[y] < reach_target)
    assert near.any(axis=1).all()
    assert set(range(32)) == set(x.tolist())


def test_points_unmatched_at_the_coarse_level_are_matched_again(levels: list[Level]) -> None:
    coarse = np.array([0, 1, 2, UNMATCHED, 4, 5, UNMATCHED, 7])
    found = refine(coarse, levels[1], rho=1.5)
    assert UNMATCHED not in found.partners


def test_too_narrow_neighbourhoods_are_widened(levels: list[Level]) -> None:
    """All coarse points on top of one another leave hardly any candidates in reach."""
    found = refine(np.array([0, *[UNMATCHED] * 7]), levels[2], rho=1.0)
    assert sorted(set(found.partners.tolist())) == sorted(found.partners.tolist())
    assert UNMATCHED not in found.partners


def test_occlusion_does_not_depend_on_the_unit_of_length() -> None:
    """γ is a cost of (5), whose distances have no unit."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(64, 3))
    noisy = points[:16] + 0.15 * rng.normal(size=(16, 3))
    structures = metric_choice("geodesic").settled(1.0), descriptor_choice("none")
    found = []
    for unit in (1e-3, 1.0, 1e3):
        source = SampledStructure(np.arange(16), unit * distances_of(noisy), None)
        target = SampledStructure(np.arange(64), unit * distances_of(points), None)
        level = Level(1, *structures, source, target, 1.0, 0.0, 0.05)
        found.append(refine(np.arange(8), level, rho=1.5))
    for other in found[1:]:
        np.testing.assert_array_equal(other.partners, found[0].partners)
        assert other.energy == pytest.approx(found[0].energy)


def test_candidates_stay_few_where_the_sizes_of_shapes_differ_a_thousandfold() -> None:
    """Pairwise costs of all 40 000 pairs would take more memory than there is."""
    small = Shape(shapes.icosphere(2), normalise=False)  # 162 vertices
    large = Shape(shapes.moved(shapes.blob(), seed=0, scale=1000.0), normalise=False)
    size = (162, min(648, large.n_vertices))
    level = build_level(small, large, 1, size, OPTIONS)
    found = refine(np.arange(8), level, rho=1.0)
    assert len(found.problem.candidates) < 5000
    assert UNMATCHED not in found.partners
    assert len(set(found.partners.tolist())) == 162
