"""Fit of a registered source to its target: how far they are apart, and how much was bent for it.

Of two maps between nearly isometric shapes, one may preserve distances, the other the details of
the surface. So a fit has several measures of different kinds, with unknown scales. Were their
errors Gaussian with unknown variances, the likelihood of a map would be the product of the inverse
mean squares: the score is the sum of the logarithms.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, RealArray
from solver.functional_maps import mutual_nearest_points
from solver.registration.alignment import Alignment, Pairs, Weights
from solver.registration.surface import Samples

_MOST_STRAIN = 2.0
"""Logarithm of a distortion beyond which it counts no more: the triangle is folded."""

_LEAST = 1e-6
"""Least measure whose logarithm is taken: those of equal surfaces are rounding errors."""


@dataclass(frozen=True)
class Fit:
    """Measures of a registered source and its target, each 0 for equal surfaces.

    All are of first order in what differs.

    Parameters
    ----------
    apart
        Mean distance in the embedding, of both directions.
    turned
        Root mean square distance of unit normals, of both directions.
    sheared
        Root of twice the mean logarithm of the conformal distortion of the displacement.
    stretched
        Mean logarithm of its change of area, up or down.
    bent
        For each diffusion time, mean change of the mean curvature, of both directions, relative to
        its mean deviation from the median: with strain, this is what the elastic energy of a thin
        shell is made of (Koiter, "On the nonlinear theory of thin elastic shells", 1966).
    """

    apart: float
    turned: float
    sheared: float
    stretched: float
    bent: tuple[float, ...]

    @property
    def measures(self) -> dict[str, float]:
        """Logarithms of the measures, by name."""
        several = {f"bent_{number}": bent for number, bent in enumerate(self.bent)}
        known = {
            "apart": self.apart,
            "turned": self.turned,
            "sheared": self.sheared,
            "stretched": self.stretched,
            **several,
        }
        return {name: float(np.log(max(one, _LEAST))) for name, one in known.items()}

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures; the less, the better."""
        return sum(self.measures.values())


def measure_fit(
    source: Samples, target: Samples, alignment: Alignment, weights: Weights
) -> tuple[Fit, Pairs]:
    """Measure the fit of an aligned source.

    Parameters
    ----------
    source, target
        S and M samples.
    alignment
        The alignment.
    weights
        Of the embedding.

    Returns
    -------
    The fit, and the nearest neighbours it was measured at.
    """
    ours, theirs = (one.astype(np.float32) for one in alignment.embed(source, target, weights))
    images, back = mutual_nearest_points(ours, theirs)
    pairs = Pairs(images, back)
    apart = 0.5 * (_mean_distance(ours, theirs[images]) + _mean_distance(theirs, ours[back]))
    normals = source.surface(alignment.coefficients)[1], target.smoothed(alignment.size)[1]
    cosines = _both_ways(pairs, *normals, lambda here, there: (here * there).sum(axis=1))
    turned = float(np.sqrt(max(2.0 - 2.0 * float(cosines), 0.0)))
    sheared, stretched = _strain(source, alignment)
    fit = Fit(apart, turned, sheared, stretched, _change_of_curvature(source, target, pairs))
    return fit, pairs


def _both_ways(
    pairs: Pairs,
    here: FloatArray,
    there: FloatArray,
    compare: Callable[[FloatArray, FloatArray], FloatArray],
) -> FloatArray:
    """Mean over the nearest neighbours of both directions, which weigh the same."""
    ours = compare(here, there[pairs.images]).mean(axis=0)
    theirs = compare(here[pairs.back], there).mean(axis=0)
    mean: FloatArray = 0.5 * (ours + theirs)
    return mean


def _mean_distance(points: RealArray, others: RealArray) -> float:
    return float(np.linalg.norm(points - others, axis=1).mean())


def _strain(source: Samples, alignment: Alignment) -> tuple[float, float]:
    """Conformal distortion and change of area, as in :class:`Fit`.

    With the first fundamental forms g of the smoothed source and G of the displaced one,
    tr(g⁻¹ G) / (2 √(det G / det g)) is at least 1, and 1 where angles are preserved.
    """
    rest = _first_form(source.derivatives(source.coefficients[: alignment.size]))
    bent = _first_form(source.derivatives(alignment.coefficients))
    (a, b, c), (p, q, r) = rest, bent
    before, after = (np.maximum(x * z - y * y, 1e-12) for x, y, z in (rest, bent))
    trace = (c * p - 2.0 * b * q + a * r) / before
    ratio = np.sqrt(after / before)
    sheared = np.minimum(np.log(np.maximum(0.5 * trace / ratio, 1.0)), _MOST_STRAIN)
    stretched = np.minimum(np.abs(np.log(ratio)), _MOST_STRAIN)
    return float(np.sqrt(2.0 * sheared.mean())), float(stretched.mean())


def _first_form(derivatives: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    u, v = derivatives
    return (u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)


def _change_of_curvature(source: Samples, target: Samples, pairs: Pairs) -> tuple[float, ...]:
    """Mean change over the mean deviation from the median, for each diffusion time."""
    here, there = source.curvatures, target.curvatures
    change = _both_ways(pairs, here, there, lambda ours, theirs: np.abs(ours - theirs))
    spread = [np.abs(one - np.median(one, axis=0)).mean(axis=0) for one in (here, there)]
    relative = change / np.maximum(np.sqrt(spread[0] * spread[1]), _LEAST)
    return tuple(relative.tolist())
