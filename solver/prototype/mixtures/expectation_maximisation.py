"""Gaussian mixtures fitted to samples by expectation maximisation, many data sets at once.

Each data set is fitted from several starts, and the fit of greatest likelihood is kept. Few samples
or equal ones would make the likelihood infinite; a floor under the covariances, which stands for a
spread that is known beforehand, keeps it finite: no variance in any direction is less. Components
that end with less than one sample's worth of weight are dropped.
"""

import numpy as np
from scipy.special import logsumexp

from solver.arrays import FloatArray, IntArray
from solver.prototype.mixtures.fit import Fit
from solver.prototype.mixtures.mixture import GaussianMixtures

_STARTS = 3
_ITERATIONS = 100
_TOLERANCE = 1e-4
"""Of the mean log-likelihood of a sample, per iteration."""
_LEAST_SHARE = 1.0
"""Samples' worth of weight below which a component is dropped."""
_NOTHING = 1e-100


def fit_mixtures(
    samples: FloatArray,
    components: int,
    floor: FloatArray,
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
        Number K of components, or the most if they are selected; no more than half the samples
        are used, and the rest has weight 0.
    floor
        (m,) least variance along each axis.
    diagonal
        Whether covariances are diagonal.
    select
        Whether each data set has the number of components of least information criterion.
    seed
        Of the random starts.

    Returns
    -------
    Fit
        Independent of the order of samples but for rounding.
    """
    most = max(min(components, samples.shape[1] // 2), 1)
    tried = range(1, most + 1) if select else [most]
    best: Fit | None = None
    for count in tried:
        fit = _fit_from_starts(samples, count, floor, diagonal, seed)
        if best is None:
            best = fit.padded(components)
            continue
        before = best.information_criterion(samples.shape[1], diagonal)
        after = fit.information_criterion(samples.shape[1], diagonal)
        best = best.exchanged(fit.padded(components), after < before)
    assert best is not None
    return best


def _fit_from_starts(
    samples: FloatArray, components: int, floor: FloatArray, diagonal: bool, seed: int
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
        fit = _pruned(ordered, maximise(ordered, started, floor, diagonal), floor, diagonal)
        if best is None:
            best = fit
        else:
            best = best.exchanged(fit, fit.log_likelihood > best.log_likelihood)
    assert best is not None
    return best


def _in_order(samples: FloatArray) -> FloatArray:
    """Sort the samples of each data set along its principal axis: any order gives this one."""
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
    """(B, K) samples in the middles of K equal parts of each ordered data set."""
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
    """Mixtures of the samples nearest to each of some of them.

    Parameters
    ----------
    samples
        (B, M, m).
    centres
        (B, K) samples.
    floor, diagonal
        Of the covariances.
    """
    chosen = np.take_along_axis(samples, centres[:, :, None], axis=1)
    apart = ((samples[:, :, None, :] - chosen[:, None, :, :]) ** 2).sum(axis=3)
    shares = np.eye(centres.shape[1])[apart.argmin(axis=2)]
    return maximisation(samples, shares, floor, diagonal)


def maximise(
    samples: FloatArray, start: GaussianMixtures, floor: FloatArray, diagonal: bool
) -> Fit:
    """Alternate expectation and maximisation until the likelihoods stand still.

    Parameters
    ----------
    samples
        (B, M, m).
    start
        B mixtures.
    floor, diagonal
        Of the covariances.
    """
    weights, means = start.weights.copy(), start.means.copy()
    covariances = start.covariances.copy()
    reached = np.full(len(samples), -np.inf)
    history: list[FloatArray] = []
    going = np.arange(len(samples))
    mixtures = start
    for _ in range(_ITERATIONS):
        joint = mixtures.log_joint(samples[going])
        densities = logsumexp(joint, axis=2)
        likelihood = densities.sum(axis=1)
        gains = (likelihood - reached[going]) / samples.shape[1]
        reached[going] = likelihood
        history.append(reached.copy())
        still = gains < _TOLERANCE
        if still.all():
            break
        going, joint, densities = going[~still], joint[~still], densities[~still]
        shares = np.exp(joint - densities[..., None])
        mixtures = maximisation(samples[going], shares, floor, diagonal)
        weights[going], means[going] = mixtures.weights, mixtures.means
        covariances[going] = mixtures.covariances
    found = GaussianMixtures(weights, means, covariances)
    reached = found.log_density(samples).sum(axis=1)
    return Fit(found, reached, np.array([*history, reached]))


def maximisation(
    samples: FloatArray, shares: FloatArray, floor: FloatArray, diagonal: bool
) -> GaussianMixtures:
    """Mixtures of greatest expected likelihood, with covariances no less than the floor.

    Parameters
    ----------
    samples
        (B, M, m).
    shares
        (B, M, K) of each component in each sample.
    floor
        (m,) least variance along each axis.
    diagonal
        Whether covariances are diagonal.

    Returns
    -------
    GaussianMixtures
        Components without any share have weight 0.
    """
    totals = shares.sum(axis=1)
    kept = totals > _NOTHING
    totals = np.where(kept, totals, 0.0)
    weights = totals / totals.sum(axis=1, keepdims=True)
    everything = samples.mean(axis=1)
    divisors = np.where(kept, totals, 1.0)
    means = np.einsum("bsk,bsi->bki", shares, samples, optimize=True) / divisors[..., None]
    means = np.where(kept[..., None], means, everything[:, None, :])
    apart = samples[:, :, None, :] - means[:, None, :, :]
    covariances = np.einsum("bsk,bski,bskj->bkij", shares, apart, apart, optimize=True)
    covariances /= divisors[..., None, None]
    return GaussianMixtures(weights, means, _floored(covariances, floor, diagonal))


def _floored(covariances: FloatArray, floor: FloatArray, diagonal: bool) -> FloatArray:
    """Raise eigenvalues, in units of the floor, to 1: the most likely matrix that is no less."""
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


def _pruned(samples: FloatArray, fit: Fit, floor: FloatArray, diagonal: bool) -> Fit:
    """Drop components of less than one sample, the smallest of each data set first, and go on."""
    while True:
        weights = fit.mixtures.weights.copy()
        smallest = np.where(weights > 0.0, weights, np.inf).argmin(axis=1)
        share = np.take_along_axis(weights, smallest[:, None], axis=1)[:, 0]
        rows = np.flatnonzero((share * samples.shape[1] < _LEAST_SHARE) & (share < 1.0))
        if not len(rows):
            return fit
        weights[rows, smallest[rows]] = 0.0
        left = weights[rows] / weights[rows].sum(axis=1, keepdims=True)
        old = fit.mixtures.chosen(rows)
        start = GaussianMixtures(left, old.means, old.covariances)
        fit = fit.replaced(rows, maximise(samples[rows], start, floor, diagonal))
