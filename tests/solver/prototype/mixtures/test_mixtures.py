"""Gaussian mixtures and their fit: against closed forms, and against scikit-learn."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal, norm
from sklearn.mixture import GaussianMixture

from solver.arrays import FloatArray
from solver.control import Control
from solver.errors import Cancelled
from solver.prototype.mixtures import GaussianMixtures, fit_from, fit_mixtures, initial_mixtures
from solver.prototype.mixtures.expectation_maximisation import maximisation

_NO_FLOOR = 1e-12


def two_bumps(count: int, seed: int = 0) -> FloatArray:
    """(1, count, 1) samples of 0.3 N(−2, 0.5²) + 0.7 N(1, 1)."""
    rng = np.random.default_rng(seed)
    left = rng.random(count) < 0.3
    samples = np.where(left, rng.normal(-2.0, 0.5, count), rng.normal(1.0, 1.0, count))
    return samples[None, :, None]


def random_mixtures(m: int, seed: int = 0) -> GaussianMixtures:
    rng = np.random.default_rng(seed)
    factors = rng.normal(size=(3, 4, m, m))
    covariances = factors @ np.swapaxes(factors, -1, -2) + 0.2 * np.eye(m)
    return GaussianMixtures(rng.dirichlet(np.ones(4), 3), rng.normal(size=(3, 4, m)), covariances)


@pytest.mark.parametrize("m", [1, 3])
def test_densities_are_those_of_the_normal_distribution(m: int) -> None:
    mixtures = random_mixtures(m)
    points = np.random.default_rng(1).normal(size=(3, 5, m))
    expected = np.zeros((3, 5))
    for b in range(3):
        for k in range(4):
            normal = multivariate_normal(mixtures.means[b, k], mixtures.covariances[b, k])
            expected[b] += mixtures.weights[b, k] * normal.pdf(points[b])
    np.testing.assert_allclose(mixtures.log_density(points), np.log(expected), rtol=1e-10)


def test_far_away_log_densities_stay_finite_and_unused_components_do_not_count() -> None:
    mixtures = GaussianMixtures(
        np.array([[1.0, 0.0]]), np.array([[[0.0], [7.0]]]), np.ones((1, 2, 1, 1))
    )
    found = mixtures.log_density(np.array([[[1e6], [7.0]]]))
    np.testing.assert_allclose(found, norm.logpdf(np.array([[1e6, 7.0]])))


def test_peaks_are_the_greatest_densities() -> None:
    mixtures = random_mixtures(1)
    line = np.broadcast_to(np.linspace(-8.0, 8.0, 20001)[None, :, None], (3, 20001, 1))
    greatest = mixtures.log_density(line).max(axis=1)
    np.testing.assert_allclose(mixtures.log_peaks, greatest, atol=1e-5)
    assert (mixtures.log_peaks >= greatest - 1e-9).all()


def test_peaks_of_the_first_mixtures_need_no_others() -> None:
    mixtures = random_mixtures(2)
    first = mixtures.first(2)
    np.testing.assert_array_equal(first.log_peaks, mixtures.log_peaks[:2])
    assert first.first(5) is first


def stepped(
    mixtures: GaussianMixtures, samples: FloatArray, floor: FloatArray, diagonal: bool
) -> GaussianMixtures:
    """Take a step of expectation maximisation."""
    responsibilities = np.exp(
        mixtures.log_joint(samples) - mixtures.log_density(samples)[..., None]
    )
    return maximisation(samples, responsibilities, floor, diagonal)


@pytest.mark.parametrize(("m", "diagonal"), [(1, False), (2, False), (2, True)])
def test_each_step_is_that_of_scikit_learn(m: int, diagonal: bool) -> None:
    samples = np.random.default_rng(3).normal(size=(1, 300, m))
    floor = np.full(m, _NO_FLOOR)
    start = initial_mixtures(samples, np.array([[0, 100, 200]]), floor, diagonal)
    precisions = np.linalg.inv(start.covariances[0])
    theirs = GaussianMixture(
        3,
        covariance_type="diag" if diagonal else "full",
        tol=0.0,
        reg_covar=0.0,
        max_iter=1,
        weights_init=start.weights[0],
        means_init=start.means[0],
        precisions_init=np.diagonal(precisions, axis1=1, axis2=2) if diagonal else precisions,
    )
    with pytest.warns(Warning, match="converge"):
        theirs.fit(samples[0])
    ours = stepped(start, samples, floor, diagonal)
    likelihood = ours.log_density(samples).sum()
    assert likelihood == pytest.approx(theirs.score(samples[0]) * 300, rel=1e-8)


def test_known_mixtures_are_recovered() -> None:
    mixtures = fit_mixtures(two_bumps(20000), 2, np.array([_NO_FLOOR]), Control()).mixtures
    order = np.argsort(mixtures.means[0, :, 0])
    np.testing.assert_allclose(mixtures.means[0, order, 0], [-2.0, 1.0], atol=0.06)
    np.testing.assert_allclose(mixtures.weights[0, order], [0.3, 0.7], atol=0.02)
    np.testing.assert_allclose(mixtures.covariances[0, order, 0, 0], [0.25, 1.0], atol=0.07)


def test_the_fit_is_as_likely_as_the_best_of_many_starts_of_scikit_learn() -> None:
    samples = two_bumps(200, seed=5)
    theirs = GaussianMixture(3, n_init=20, reg_covar=0.01, random_state=0).fit(samples[0])
    ours = fit_mixtures(samples, 3, np.array([0.01]), Control())
    assert ours.log_likelihood[0] >= 200 * theirs.score(samples[0]) - 2.0


@settings(max_examples=25)
@given(
    seed=st.integers(0, 2**16),
    count=st.integers(2, 40),
    m=st.integers(1, 3),
    components=st.integers(1, 5),
    diagonal=st.booleans(),
)
def test_the_likelihood_never_falls_and_covariances_stay_above_the_floor(
    seed: int, count: int, m: int, components: int, diagonal: bool
) -> None:
    rng = np.random.default_rng(seed)
    samples = np.round(rng.normal(size=(4, count, m)), 1)  # with ties
    floor = rng.uniform(0.01, 0.5, m)
    centres = rng.integers(count, size=(4, components))
    start = initial_mixtures(samples, centres, floor, diagonal)
    steps = [start]
    for _ in range(5):
        steps.append(stepped(steps[-1], samples, floor, diagonal))
    fit = fit_from(samples, start, floor, diagonal, Control())
    likelihoods = np.array([one.log_density(samples).sum(axis=1) for one in steps])
    rounding = 1e-8 * np.abs(likelihoods[1:])
    assert (np.diff(likelihoods, axis=0) >= -rounding).all()
    assert (fit.log_likelihood >= likelihoods[1] - rounding[0]).all()
    scaled = fit.mixtures.covariances / np.sqrt(np.outer(floor, floor))
    assert np.linalg.eigvalsh(scaled).min() >= 1.0 - 1e-9


@settings(max_examples=25)
@given(seed=st.integers(0, 2**16), count=st.integers(1, 12), components=st.integers(1, 8))
def test_any_samples_have_a_sound_fit(seed: int, count: int, components: int) -> None:
    rng = np.random.default_rng(seed)
    samples = rng.choice([0.0, 1.0, 5.0], size=(3, count, 1))
    samples[0] = 2.0  # one of them constant
    fit = fit_mixtures(samples, components, np.array([0.1]), Control(), seed=seed)
    assert fit.mixtures.weights.shape == (3, components)
    assert np.isfinite(fit.log_likelihood).all()
    np.testing.assert_allclose(fit.mixtures.weights.sum(axis=1), 1.0)
    used = fit.mixtures.weights[0] > 0.0
    np.testing.assert_allclose(fit.mixtures.means[0, used], 2.0)
    assert used.sum() <= max(count // 2, 1)


@pytest.mark.parametrize("m", [1, 3])
def test_the_order_of_samples_does_not_matter(m: int) -> None:
    rng = np.random.default_rng(0)
    samples = rng.normal(size=(5, 30, m))
    shuffled = samples[:, rng.permutation(30)]
    one, two = (fit_mixtures(each, 3, np.full(m, 0.01), Control()) for each in (samples, shuffled))
    np.testing.assert_allclose(one.log_likelihood, two.log_likelihood, rtol=1e-9)
    points = rng.normal(size=(5, 7, m))
    here, there = (fit.mixtures.log_density(points) for fit in (one, two))
    np.testing.assert_allclose(here, there, rtol=1e-6, atol=1e-6)


def test_a_single_sample_has_the_floor_as_its_variance() -> None:
    fit = fit_mixtures(np.array([[[3.0]]]), 5, np.array([0.04]), Control())
    assert fit.mixtures.log_density(np.array([[[3.2]]]))[0, 0] == pytest.approx(
        norm.logpdf(3.2, 3.0, 0.2)
    )


def test_a_fit_can_be_cancelled_while_it_is_iterated() -> None:
    checks = iter([False] * 5)
    control = Control(is_cancelled=lambda: next(checks, True))
    with pytest.raises(Cancelled):
        fit_mixtures(two_bumps(200), 3, np.array([_NO_FLOOR]), control)
    assert next(checks, None) is None


def test_the_information_criterion_chooses_as_many_components_as_there_are() -> None:
    one = np.random.default_rng(0).normal(size=(1, 400, 1))
    fits = [
        fit_mixtures(samples, 4, np.array([0.01]), Control(), select=True)
        for samples in (one, two_bumps(400, seed=1))
    ]
    assert [int((fit.mixtures.weights > 0.0).sum()) for fit in fits] == [1, 2]


def test_invalid_mixtures_are_refused() -> None:
    sound = random_mixtures(2)
    for weights, covariances in (
        (2.0 * sound.weights, sound.covariances),
        (sound.weights, -sound.covariances),
        (sound.weights, sound.covariances + np.array([[0.0, 1.0], [0.0, 0.0]])),
        (np.full_like(sound.weights, np.nan), sound.covariances),
    ):
        with pytest.raises(ValueError, match=r"weights|covariances|finite"):
            GaussianMixtures(weights, sound.means, covariances)
