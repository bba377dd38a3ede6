"""Fit of a registered source to its target: how far they are apart, and how much was bent for it.

Of two maps between nearly isometric shapes, one may preserve distances, the other the details of
the surface. So a fit has several measures of different kinds, with unknown scales. Were their
errors Gaussian with unknown variances, the likelihood of a map would be the product of the inverse
mean squares: the score is the sum of the logarithms.
"""

from dataclasses import asdict, dataclass

import numpy as np

from solver.arrays import FloatArray
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

    Parameters
    ----------
    apart
        Mean distance in the embedding, of both directions.
    turned
        Mean of 1 − cos of the angle between normals, of both directions.
    sheared
        Mean logarithm of the conformal distortion of the displacement.
    stretched
        Mean logarithm of its change of area, up or down.
    bent
        Mean change of mean curvatures, relative to their mean deviations: with strain, this is what
        the elastic energy of a thin shell is made of (Koiter 1966).
    """

    apart: float
    turned: float
    sheared: float
    stretched: float
    bent: float

    @property
    def measures(self) -> dict[str, float]:
        """Logarithms of the measures, by name."""
        return {
            name: float(np.log(max(measure, _LEAST))) for name, measure in asdict(self).items()
        }

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures; the less, the better."""
        apart, turned, sheared, stretched, bent = self.measures.values()
        # Angles are of second order in the difference of normals, and both strains are one kind.
        return 2.0 * apart + turned + 0.5 * (sheared + stretched) + 2.0 * bent


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
    apart = 0.5 * (_mean_distance(ours, theirs[images]) + _mean_distance(theirs, ours[back]))
    here = source.surface(alignment.coefficients)[1]
    there = target.smoothed(alignment.size)[1]
    cosines = [(here * there[images]).sum(axis=1), (here[back] * there).sum(axis=1)]
    sheared, stretched = _strain(source, alignment)
    curved = source.curvatures, target.curvatures[images]
    fit = Fit(apart, 1.0 - 0.5 * float(cosines[0].mean() + cosines[1].mean()), sheared, stretched, _change_of_curvature(*curved))
    return fit, Pairs(images, back)


def _mean_distance(points: FloatArray, others: FloatArray) -> float:
    return float(np.linalg.norm(points - others, axis=1).mean())


def _strain(source: Samples, alignment: Alignment) -> tuple[float, float]:
    """Mean logarithms of the conformal distortion and of the change of area.

    With the first fundamental forms g of the smoothed source and G of the displaced one,
    tr(g⁻¹ G) / (2 √(det G / det g)) is at least 1, and 1 where angles are preserved.
    """
    rest = _first_form(source.derivatives(source.coefficients[: alignment.size]))
    bent = _first_form(source.derivatives(alignment.coefficients))
    (a, b, c), (p, q, r) = rest, bent
    before, after = (np.maximum(x * z - y * y, 1e-12) for x, y, z in (rest, bent))
    trace = (c * p - 2.0 * b * q + a * r) / before
    ratio = np.sqrt(after / before)
    sheared = np.log(np.maximum(0.5 * trace / ratio, 1.0))
    stretched = np.abs(np.log(ratio))
    return tuple(float(np.minimum(one, _MOST_STRAIN).mean()) for one in (sheared, stretched))  # type: ignore[return-value]


def _first_form(derivatives: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    u, v = derivatives
    return (u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)


def _change_of_curvature(here: FloatArray, there: FloatArray) -> float:
    """Mean change, over the mean deviation from the median; of all diffusion times."""
    change = np.abs(here - there).mean(axis=0)
    spread = [np.abs(one - np.median(one, axis=0)).mean(axis=0) for one in (here, there)]
    relative = change / np.maximum(np.sqrt(spread[0] * spread[1]), _LEAST)
    return float(relative.mean())
