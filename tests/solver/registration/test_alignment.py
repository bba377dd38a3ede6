"""Fits of displacements, functional maps and rotations against plain references."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import orthogonal_procrustes
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray
from solver.functional_maps import FunctionalMap
from solver.mesh import triangle_mesh
from solver.registration.alignment import (
    GLOBAL,
    LEAST_RIDGE,
    LOCAL,
    RIDGE,
    Alignment,
    Pairs,
    Weights,
    align,
    fit_alignment,
    rotation_onto,
)
from solver.registration.surface import Samples, SmoothSurface, smooth_surface
from solver.shape import Shape
from tests.solver import shapes

SEEDS = st.integers(0, 2**31 - 1)


def pairs_between(samples: Samples, others: Samples, seed: int) -> Pairs:
    random = np.random.default_rng(seed)
    n, m = len(samples), len(others)
    return Pairs.of_all(random.integers(m, size=n), random.integers(n, size=m))


def identity(samples: Samples, k: int) -> Alignment:
    return Alignment(samples.coefficients[:k], FunctionalMap(np.eye(k)), np.eye(3))


def test_a_fit_is_the_weighted_least_squares_solution(surface: SmoothSurface) -> None:
    """Rows of pairs in both directions and rows of the ridge, solved at once."""
    source, target, k = surface.samples.first(80), surface.samples.first(130), 20
    pairs = pairs_between(source, target, 1)
    found = fit_alignment(source, target, pairs, k)

    rows, goals = [], []
    turned = source.coefficients[:k] @ found.turn
    here, there = source.eigenfunctions[:, :k], target.smoothed(k)[0]
    corresponding = [(i, j, 0.5 / 80) for i, j in enumerate(pairs.images)]
    corresponding += [(i, j, 0.5 / 130) for j, i in enumerate(pairs.back)]
    for i, j, weight in corresponding:
        rows.append(np.sqrt(weight) * here[i])
        goals.append(np.sqrt(weight) * (there[j] - here[i] @ turned))
    for i in range(k):
        penalty = RIDGE * source.eigenvalues[i] / source.eigenvalues[-1] + LEAST_RIDGE
        rows.append(np.sqrt(penalty) * np.eye(k)[i])
        goals.append(np.zeros(3))
    expected = np.linalg.lstsq(np.array(rows), np.array(goals), rcond=None)[0]
    np.testing.assert_allclose(found.coefficients - turned, expected, atol=1e-7)

    weights = np.array([weight for _, _, weight in corresponding])
    i, j = np.array([pair[:2] for pair in corresponding]).T
    plain = rotation_onto(source.smoothed(k)[0][i], there[j], weights[:, None])
    np.testing.assert_allclose(found.turn, plain, atol=1e-12)
    scaled = np.sqrt(weights)[:, None]
    turn, _ = orthogonal_procrustes(scaled * here[i], scaled * target.eigenfunctions[j, :k])
    np.testing.assert_allclose(found.functional_map.matrix, turn.T, atol=1e-9)


def test_partners_are_means_over_the_pairs_of_both_directions() -> None:
    pairs = Pairs.of_all(np.array([2, 0]), np.array([0, 0, 1]))
    values = np.array([[1.0, 5.0], [2.0, 6.0], [4.0, 7.0]])
    a, b = 1.0 / 4.0, 1.0 / 6.0
    np.testing.assert_allclose(pairs.weights[:, 0], [a + 2.0 * b, a + b])
    expected = [(a * 4.0 + b * (1.0 + 2.0)) / (a + 2.0 * b), (a * 1.0 + b * 4.0) / (a + b)]
    np.testing.assert_allclose(pairs.partners(values, 1)[:, 0], expected)


def test_samples_without_a_partner_are_left_out() -> None:
    """The second source sample is in no pair; of the first, one pair of each direction is left."""
    covered, met = np.array([True, False, True]), np.array([True, False, True])
    pairs = Pairs(np.array([1, 2, 0]), np.array([0, 1, 2]), covered, met)
    values = np.array([[1.0], [2.0], [4.0]])
    np.testing.assert_array_equal(pairs.rows, [0, 2])
    np.testing.assert_allclose(pairs.weights, [[0.5], [0.5]])
    np.testing.assert_allclose(pairs.partners(values, 1), [[1.5], [2.5]])
    part = Pairs.of_part(np.array([2, 2, 0]), 3)
    np.testing.assert_array_equal(part.rows, [0, 2])
    np.testing.assert_allclose(part.weights, [[1.0 / 6.0], [1.0 / 3.0]])
    np.testing.assert_allclose(part.partners(values, 1), [[4.0], [1.5]])


def test_true_pairs_of_a_moved_copy_fit_exactly(surface: SmoothSurface) -> None:
    mesh = shapes.blob()
    turn = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix()
    other = smooth_surface(Shape(triangle_mesh(5.0 * mesh.vertices @ turn, mesh.faces)))
    source, target = surface.samples, other.samples
    same = np.arange(len(source))
    found = fit_alignment(source, target, Pairs.of_all(same, same), 50)
    np.testing.assert_allclose(found.turn, turn, atol=1e-6)
    positions, normals = source.surface(found.coefficients)
    expected, expected_normals = target.smoothed(50)
    np.testing.assert_allclose(positions, expected, atol=1e-6)
    np.testing.assert_allclose(normals, expected_normals, atol=1e-5)


def test_the_number_of_eigenfunctions_is_at_most_what_there_is(surface: SmoothSurface) -> None:
    samples = surface.samples
    found = fit_alignment(samples, samples, pairs_between(samples, samples, 0), 1000)
    assert found.size == found.functional_map.size == samples.size


def test_the_embedding_has_the_weights_it_says(surface: SmoothSurface) -> None:
    samples, k = surface.samples, 16
    ours, theirs = identity(samples, k).embed(samples, samples, Weights(0.5, 3.0, 0.25))
    np.testing.assert_allclose(ours, theirs, atol=1e-12)
    assert ours.shape == (len(samples), 6 + k)
    positions, normals = samples.smoothed(k)
    expected = 3.0 * positions, 0.25 * normals, 0.5 / 4.0 * samples.eigenfunctions[:, :k]
    np.testing.assert_allclose(ours, np.hstack(expected), rtol=1e-6, atol=1e-6)


def test_nearest_neighbours_of_both_directions(surface: SmoothSurface) -> None:
    source, target = surface.samples.first(60), surface.samples.first(100)
    alignment = fit_alignment(source, target, pairs_between(source, target, 2), 12)
    ours, theirs = alignment.embed(source, target, GLOBAL)
    apart = np.linalg.norm(ours[:, None] - theirs[None], axis=2)
    found = alignment.pairs(source, target, GLOBAL)
    np.testing.assert_allclose(apart[np.arange(60), found.images], apart.min(axis=1), rtol=1e-4)
    np.testing.assert_allclose(apart[found.back, np.arange(100)], apart.min(axis=0), rtol=1e-4)


def test_alignment_goes_through_the_sizes(surface: SmoothSurface) -> None:
    samples = surface.samples
    same = np.arange(len(samples))
    found = align(samples, samples, Pairs.of_all(same, same), (12, 20, 40), LOCAL)
    assert found.size == 40
    np.testing.assert_array_equal(found.pairs(samples, samples, LOCAL).images, same)


def points_from(seed: int, noise: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    random = np.random.default_rng(seed)
    here = random.standard_normal((12, 3))
    turn = Rotation.random(random_state=seed).as_matrix()
    there = here @ turn + noise * random.standard_normal((12, 3)) + random.standard_normal(3)
    weights = random.uniform(0.1, 1.0, (12, 1))
    return here, there, weights / weights.sum()


@given(SEEDS)
def test_a_rotation_is_that_of_scipy(seed: int) -> None:
    here, there, weights = points_from(seed, 0.1)
    a, b = (one - (weights * one).sum(axis=0) for one in (here, there))
    expected, _ = Rotation.align_vectors(b, a, weights=weights[:, 0])
    found = rotation_onto(here, there, weights)
    np.testing.assert_allclose(found, expected.as_matrix().T, atol=1e-7)


@given(SEEDS)
def test_a_rotation_is_never_a_reflection(seed: int) -> None:
    here, there, weights = points_from(seed, 0.01)
    found = rotation_onto(here, there * [-1.0, 1.0, 1.0], weights)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(found) > 0.0
