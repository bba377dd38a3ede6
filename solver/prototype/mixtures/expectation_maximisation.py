"""Gaussian mixtures fitted to many data sets at once by expectation maximisation (section 5).

Each data set is fitted from several starts, and the fit of greatest likelihood is kept. With few or
equal samples the likelihood is unbounded; a floor under the covariances, a spread known beforehand,
bounds it: no variance in any direction is less. Components of less weight than one sample are
dropped.

scikit-learn's `GaussianMixture` fits one data set at a time, while a prototype has N(N − 1)/2, and
adds a constant to variances instead of a floor.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from solver.arrays import FloatArray, IntArray
from solver.control import Control, iterate
from solver.prototype.mixtures.fit import Fit
from solver.prototype.mixtures.mixture import GaussianMixtures

_STARTS = 3
"""Starts of each fit: one of quantiles, the others of k-means++."""

_MAX_ITERATIONS = 100

_TOLERANCE = 1e-4
"""Rise of the mean log-likelihood of a sample in an iteration below which a fit has converged."""

_MIN_SAMPLES = 1.0
"""Expected number of samples of a component below which it is dropped."""

_MIN_RESPONSIBILITY = 1e-100
"""Sum of responsibilities below which a component is unused: division by it would overflow."""


def fit_mixtures(
    samples: FloatArray,
    components: int,
    floor: FloatArray,
    control: Control,
    *,
    diagonal: bool = False,
    select: bool = False,
    seed: int = 0,
) -> Fit:
    """Fit a Gaussian mixture to each of many data sets.

    Parameters
    ----------
    samples
        (B, M, m) M samples of each data set.
    components
        Number K of components, or the greatest number if it is selected. At most M/2 are used; the
        others have weight 0.
    floor
        (m,) least variance along each axis.
    control
        Cancels; past its deadline, the fits are those of fewer iterations.
    diagonal
        Whether covariances are diagonal.
    select
        Whether to select each data set's number of components by the Bayesian information criterion
        (BIC).
    seed
        Of the random starts.

    Returns
    -------
    Fit
        Independent of the order of samples up to rounding.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    most = max(min(components, samples.shape[1] // 2), 1)
    tried = range(1, most + 1) if select else [most]
    best: Fit | None = None
    for count in tried:
        fit = _fit_from_starts(samples, count, floor, diagonal, seed, control)
        if best is None:
            best = fit.padded(components)
            continue
        before = best.information_criterion(samples.shape[1], diagonal)
        after = fit.information_criterion(samples.shape[1], diagonal)
        best = best.best_of(fit.padded(components), after < before)
    assert best is not None
    return best


def _fit_from_starts(
    samples: FloatArray,
    components: int,
    floor: FloatArray,
    diagonal: bool,
    seed: int,
    control: Control,
) -> Fit:
    ordered = _in_order(samples)
    best: Fit | None = None
    for start in range(_STARTS if components > 1 else 1):
        centres = (
            _quantile_centres(ordered, components)
            if start == 0
            else _spread_centres(ordered, components, np.random.default_rng([seed, start]))
        )
        started = initial_mixtures(ordered, centres, floor, diagonal)
        fit = fit_from(ordered, started, floor, diagonal, control)
        fit = _pruned(ordered, fit, floor, diagonal, control)
        best = best.best_of(fit, fit.log_likelihood > best.log_likelihood) if best else fit
    assert best is not None
    return best


def _in_order(samples: FloatArray) -> FloatArray:
    """Sort the samples of each data set along its principal axis, to be independent of order."""
    centred = samples - samples.mean(axis=1, keepdims=True)
    if samples.shape[2] == 1:
        along = samples[:, :, 0]
    else:
        _, vectors = np.linalg.eigh(np.einsum("bsi,bsj->bij", centred, centred))
        axis = vectors[:, :, -1]
        largest = np.take_along_axis(axis, np.abs(axis).argmax(axis=1)[:, None], axis=1)
        along = np.einsum("bsi,bi->bs", centred, axis * np.sign(largest))
    order = np.argsort(along, axis=1, kind="stable")
    result: FloatArray = np.take_along_axis(samples, order[:, :, None], axis=1)
    return result


def _quantile_centres(ordered: FloatArray, components: int) -> IntArray:
    """(B, K) samples at the middles of K quantile intervals of each ordered data set."""
    places = ((np.arange(components) + 0.5) / components * ordered.shape[1]).astype(np.int64)
    return np.broadcast_to(places, (len(ordered), components))


def _spread_centres(ordered: FloatArray, components: int, rng: np.random.Generator) -> IntArray:
    """(B, K) samples by k-means++ (Arthur and Vassilvitskii, SODA 2007)."""
    count, size, _ = ordered.shape
    centres = np.empty((count, components), dtype=np.int64)
    centres[:, 0] = rng.integers(size, size=count)
    nearest = np.full((count, size), np.inf)
    rows = np.arange(count)
    for k in range(1, components):
        apart = ordered - ordered[rows, centres[:, k - 1]][:, None, :]
        nearest = np.minimum(nearest, (apart**2).sum(axis=2))
        sums = np.cumsum(nearest, axis=1)
        draws = rng.random(count) * sums[:, -1]
        centres[:, k] = np.minimum((sums <= draws[:, None]).sum(axis=1), size - 1)
    return centres


def initial_mixtures(
    samples: FloatArray, centres: IntArray, floor: FloatArray, diagonal: bool
) -> GaussianMixtures:
    """Return mixtures of the samples nearest to each centre: one step of k-means.

    Parameters
    ----------
    samples
        (B, M, m).
    centres
        (B, K) indices of samples.
    floor, diagonal
        Of the covariances.
    """
    chosen = np.take_along_axis(samples, centres[:, :, None], axis=1)
    apart = ((samples[:, :, None, :] - chosen[:, None, :, :]) ** 2).sum(axis=3)
    responsibilities = np.eye(centres.shape[1])[apart.argmin(axis=2)]
    return maximisation(samples, responsibilities, floor, diagonal)


def fit_from(
    samples: FloatArray,
    start: GaussianMixtures,
    floor: FloatArray,
    diagonal: bool,
    control: Control,
) -> Fit:
    """Fit mixtures by expectation maximisation until their likelihoods converge.

    Parameters
    ----------
    samples
        (B, M, m).
    start
        B mixtures.
    floor, diagonal
        Of the covariances.
    control
        Cancels; past its deadline no further iteration begins.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    method = _ExpectationMaximisation(samples, start, floor, diagonal)
    state = iterate(method, _MAX_ITERATIONS, control).state
    found = GaussianMixtures(state.weights, state.means, state.covariances)
    return Fit(found, state.log_likelihood)


@dataclass(eq=False)
class _State:
    """State of an expectation maximisation, which its steps change.

    Parameters
    ----------
    weights, means, covariances
        Of all B mixtures.
    log_likelihood
        (B,) of all mixtures.
    active, current
        (A,) mixtures that have not converged, and their parameters.
    responsibilities
        (A, M, K) posterior probabilities of the components for each of their samples.
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray
    log_likelihood: FloatArray
    active: IntArray
    current: GaussianMixtures
    responsibilities: FloatArray


@dataclass(frozen=True, eq=False)
class _ExpectationMaximisation:
    """Expectation maximisation of many data sets at once (Dempster, Laird, Rubin 1977)."""

    samples: FloatArray
    start: GaussianMixtures
    floor: FloatArray
    diagonal: bool

    def init(self) -> _State:
        """Return the start with its responsibilities."""
        start, count = self.start, len(self.samples)
        parameters = start.weights.copy(), start.means.copy(), start.covariances.copy()
        unknown = np.full(count, -np.inf)
        state = _State(*parameters, unknown, np.arange(count), start, np.zeros(0))
        self._expect(state)
        return state

    def step(self, state: _State) -> _State:
        """Maximise the parameters of the active mixtures, and their responsibilities."""
        active = state.active
        state.current = maximisation(
            self.samples[active], state.responsibilities, self.floor, self.diagonal
        )
        state.weights[active], state.means[active] = state.current.weights, state.current.means
        state.covariances[active] = state.current.covariances
        self._expect(state)
        return state

    def done(self, state: _State) -> bool:
        """Return whether all mixtures have converged."""
        return not len(state.active)

    def _expect(self, state: _State) -> None:
        """Compute responsibilities; mixtures whose likelihood hardly rises are no longer active."""
        joint = state.current.log_joint(self.samples[state.active])
        densities = logsumexp(joint, axis=2)
        likelihood = densities.sum(axis=1)
        gains = (likelihood - state.log_likelihood[state.active]) / self.samples.shape[1]
        state.log_likelihood[state.active] = likelihood
        rising = ~(gains < _TOLERANCE)
        state.active = state.active[rising]
        state.responsibilities = np.exp(joint[rising] - densities[rising][..., None])


def maximisation(
    samples: FloatArray, responsibilities: FloatArray, floor: FloatArray, diagonal: bool
) -> GaussianMixtures:
    """Return the mixtures of greatest expected likelihood, with covariances above the floor.

    Parameters
    ----------
    samples
        (B, M, m).
    responsibilities
        (B, M, K) responsibilities of the components for each sample.
    floor
        (m,) least variance along each axis.
    diagonal
        Whether covariances are diagonal.

    Returns
    -------
    GaussianMixtures
        Components without responsibility have weight 0.
    """
    totals = responsibilities.sum(axis=1)
    kept = totals > _MIN_RESPONSIBILITY
    totals = np.where(kept, totals, 0.0)
    weights = totals / totals.sum(axis=1, keepdims=True)
    everything = samples.mean(axis=1)
    divisors = np.where(kept, totals, 1.0)
    shares = np.swapaxes(responsibilities, 1, 2) / divisors[..., None]
    means = np.where(kept[..., None], shares @ samples, everything[:, None, :])
    apart = samples[:, None, :, :] - means[:, :, None, :]
    covariances = np.swapaxes(shares[..., None] * apart, -1, -2) @ apart
    return GaussianMixtures(weights, means, _floored(covariances, floor, diagonal))


def _floored(covariances: FloatArray, floor: FloatArray, diagonal: bool) -> FloatArray:
    """Raise eigenvalues relative to the floor to 1: the most likely matrices not below it."""
    unit = np.sqrt(floor)
    if diagonal or covariances.shape[-1] == 1:
        variances = np.maximum(np.diagonal(covariances, axis1=-2, axis2=-1), floor)
        result: FloatArray = variances[..., None] * np.eye(len(floor))
        return result
    values, vectors = np.linalg.eigh(covariances / np.outer(unit, unit))
    values = np.maximum(values, 1.0)
    scaled = vectors * np.sqrt(values)[..., None, :] * unit[:, None]
    raised: FloatArray = scaled @ np.swapaxes(scaled, -1, -2)
    return raised


def _pruned(
    samples: FloatArray, fit: Fit, floor: FloatArray, diagonal: bool, control: Control
) -> Fit:
    """Drop components of less than one sample, the smallest of each data set first, and refit."""
    while True:
        weights = fit.mixtures.weights.copy()
        smallest = np.where(weights > 0.0, weights, np.inf).argmin(axis=1)
        share = np.take_along_axis(weights, smallest[:, None], axis=1)[:, 0]
        rows = np.flatnonzero((share * samples.shape[1] < _MIN_SAMPLES) & (share < 1.0))
        if not len(rows):
            return fit
        weights[rows, smallest[rows]] = 0.0
        left = weights[rows] / weights[rows].sum(axis=1, keepdims=True)
        old = fit.mixtures.chosen(rows)
        start = GaussianMixtures(left, old.means, old.covariances)
        fit = fit.replaced(rows, fit_from(samples[rows], start, floor, diagonal, control))
