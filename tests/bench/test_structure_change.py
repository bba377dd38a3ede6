"""What theory says of the change of structures, asserted of what the experiment measures."""

from dataclasses import replace

import numpy as np
import pytest

from bench.collection import KnownShape, Pair
from bench.structure_change import (
    assignment_error,
    change,
    descriptors,
    distances,
    known_points,
    matching_error,
    partners_of,
    structures,
)
from solver.mesh import TriangleMesh
from solver.shape import Shape
from solver.shape.choices import (
    Biharmonic,
    CommuteTime,
    ConformalFactor,
    DescriptorChoice,
    Diffusion,
    Eigenfunctions,
    GaussianCurvature,
    Geodesic,
    GeodesicHistogram,
    HeatKernelSignature,
    MetricChoice,
    Photometric,
    ScaleInvariantHeatKernelSignature,
    Structure,
    WaveKernelSignature,
)
from synthetic import painted
from tests.solver.shapes import blob, moved

FACTOR = 2.0
SCALE_INVARIANT = (
    Photometric(radius=0.0),
    ConformalFactor(),
    Eigenfunctions(),
    ScaleInvariantHeatKernelSignature(),
    WaveKernelSignature(),
    CommuteTime(),
)


def pair_of(target: TriangleMesh) -> Pair:
    """The blob of unit area beside a mesh of the same vertices, in the same unit."""
    source = blob(2)
    unit = 1.0 / np.sqrt(source.area)
    every = np.arange(source.n_vertices)
    known = []
    for mesh in (source, target):
        colored = replace(mesh, vertices=unit * mesh.vertices, colors=painted(source.vertices))
        shape = Shape(colored, normalise=False, eigenpairs=40)
        known.append(KnownShape("blob", "blob", shape, every, every))
    return known[0], known[1]


@pytest.fixture(scope="module")
def scaled_pair() -> Pair:
    return pair_of(replace(blob(2), vertices=FACTOR * blob(2).vertices))


@pytest.mark.parametrize("structure", structures(), ids=str)
def test_nothing_changes_under_rigid_motion(structure: Structure) -> None:
    pair = pair_of(moved(blob(2), seed=3))
    assert change(structure, pair) < 1e-6
    assert matching_error(partners_of(structure), pair) == 0.0


@pytest.mark.parametrize("structure", SCALE_INVARIANT, ids=str)
def test_scale_invariant_structures_do_not_change(structure: Structure, scaled_pair: Pair) -> None:
    assert change(structure, scaled_pair) < 1e-6


@pytest.mark.parametrize("metric", [Geodesic(), Biharmonic()], ids=str)
def test_metrics_that_are_lengths_grow_by_the_factor(
    metric: MetricChoice, scaled_pair: Pair
) -> None:
    here, there = known_points(scaled_pair, 60)
    before, after = distances(metric, scaled_pair, here, there)
    np.testing.assert_allclose(after, FACTOR * before, rtol=1e-9)
    apart = before[np.triu_indices(len(here), 1)]
    expected = (FACTOR - 1.0) * np.sqrt((apart**2).mean()) / (np.sqrt(2.0) * apart.std())
    assert change(metric, scaled_pair) == pytest.approx(expected, rel=1e-9)


def test_heat_has_come_less_far_on_a_larger_shape(scaled_pair: Pair) -> None:
    """d_t on sX is d_{t/s²} on X over s: equation (3)."""
    here, there = known_points(scaled_pair, 60)
    before, after = distances(Diffusion(time=0.02), scaled_pair, here, there)
    earlier, _ = distances(Diffusion(time=0.02 / FACTOR**2), scaled_pair, here, there)
    np.testing.assert_allclose(after, earlier / FACTOR, rtol=1e-9)
    assert not np.allclose(before, after, rtol=0.1)


@pytest.mark.parametrize(
    ("structure", "on_original", "power"),
    [
        (HeatKernelSignature(times=(0.02, 0.1)), HeatKernelSignature(times=(0.005, 0.025)), 0),
        (GeodesicHistogram(radius=0.3), GeodesicHistogram(radius=0.15), 0),
        (Photometric(radius=0.3), Photometric(radius=0.15), 0),
        (GaussianCurvature(scale=0.3), GaussianCurvature(scale=0.15), -2),
    ],
    ids=str,
)
def test_a_radius_is_half_as_large_on_a_shape_of_twice_the_size(
    structure: DescriptorChoice, on_original: DescriptorChoice, power: int, scaled_pair: Pair
) -> None:
    here, there = known_points(scaled_pair, 60)
    before, after = descriptors(structure, scaled_pair, here, there)
    smaller, _ = descriptors(on_original, scaled_pair, here, there)
    np.testing.assert_allclose(after, FACTOR**power * smaller, rtol=1e-6, atol=1e-12)
    spread = before.var(axis=0).sum() * 2.0 * len(here) / (len(here) - 1)
    expected = np.sqrt(((after - before) ** 2).sum(axis=1).mean() / spread)
    assert change(structure, scaled_pair) == pytest.approx(expected, rel=1e-9)
    assert expected > 0.01


def test_images_are_matched_to_what_they_are_images_of(scaled_pair: Pair) -> None:
    assert assignment_error(partners_of(CommuteTime()), scaled_pair) == 0.0


def test_change_is_relative_to_that_from_point_to_point() -> None:
    """Truth that is no truth: corresponding points are as different as any."""
    source, target = pair_of(blob(2))
    assert source.truth is not None
    shuffled = np.random.default_rng(5).permutation(source.truth)
    wrong = source, replace(target, truth=shuffled)
    for structure in (Geodesic(), HeatKernelSignature()):
        assert change(structure, wrong) == pytest.approx(1.0, abs=0.25)
