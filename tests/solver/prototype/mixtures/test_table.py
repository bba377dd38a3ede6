"""Tabulated likelihoods against the mixtures' own."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.labelling import NO_TABLE
from solver.prototype.matching import negative_log_likelihoods
from solver.prototype.mixtures import GaussianMixtures, likelihood_table

POINTS, SAMPLES = 4, 7
EVERYTHING = np.argwhere(np.ones((POINTS, SAMPLES), dtype=np.bool_)).astype(np.int64)
SOME = EVERYTHING[np.random.default_rng(5).random(len(EVERYTHING)) < 0.5]
NONE = EVERYTHING[:0]


def mixtures(rng: np.random.Generator) -> GaussianMixtures:
    """Of six distances, some narrow and far from one another, one of them of a single Gaussian."""
    pairs = POINTS * (POINTS - 1) // 2
    weights = rng.dirichlet(np.ones(3), size=pairs)
    weights[2] = 1.0, 0.0, 0.0
    means = 3.0 * rng.random((pairs, 3, 1))
    return GaussianMixtures(weights, means, (0.03 + rng.random((pairs, 3, 1, 1))) ** 2)


def sampled(rng: np.random.Generator) -> FloatArray:
    """Distances among samples in space."""
    places = 2.0 * rng.random((SAMPLES, 3))
    return np.asarray(np.linalg.norm(places[:, None] - places[None], axis=2))


def tabulated(
    learned: GaussianMixtures,
    distances: FloatArray,
    candidates: IntArray,
    log_background: float,
    known: FloatArray = NO_TABLE,
    within: IntArray | None = None,
) -> FloatArray:
    roots = learned.roots[:, :, 0, 0]
    return likelihood_table(
        candidates,
        distances,
        learned.log_weights + np.log(roots) - 0.5 * np.log(2.0 * np.pi),
        learned.means[:, :, 0],
        roots,
        np.logaddexp(learned.log_peaks, log_background),
        log_background,
        0.7,
        known,
        np.full(len(candidates), -1) if within is None else within,
    )


@pytest.mark.parametrize("log_background", [-14.0, -2.0, -200.0])
@pytest.mark.parametrize("candidates", [EVERYTHING, SOME, NONE], ids=["all", "some", "none"])
def test_table_is_of_log_densities(candidates: IntArray, log_background: float) -> None:
    rng = np.random.default_rng(3)
    learned = mixtures(rng)
    distances = sampled(rng)
    table = tabulated(learned, distances, candidates, log_background)
    everywhere = np.broadcast_to(distances.reshape(1, -1, 1), (len(learned), SAMPLES**2, 1))
    costs = negative_log_likelihoods(
        learned.log_density(everywhere), learned.log_peaks[:, None], log_background
    )
    assert table.shape == (len(candidates), len(candidates))
    for a, (x, y) in enumerate(candidates):
        for b, (other, z) in enumerate(candidates):
            if x == other or y == z:
                assert table[a, b] == 0.0
                continue
            low, high = min(x, other), max(x, other)
            expected = 0.7 * costs[high * (high - 1) // 2 + low, y * SAMPLES + z]
            assert table[a, b] == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_an_earlier_table_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    learned, distances = mixtures(rng), sampled(rng)
    everything = tabulated(learned, distances, EVERYTHING, -14.0)
    chosen = rng.random((2, len(EVERYTHING))) < rng.uniform(0.3, 0.9)
    earlier, candidates = (EVERYTHING[one] for one in chosen)
    place = np.cumsum(chosen[0]) - 1
    within = np.where(chosen[0], place, -1)[chosen[1]]
    known = tabulated(learned, distances, earlier, -14.0)
    table = tabulated(learned, distances, candidates, -14.0, known, within)
    np.testing.assert_array_equal(table, everything[np.ix_(chosen[1], chosen[1])])
