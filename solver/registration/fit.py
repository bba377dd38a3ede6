"""Fit of a registered source to its target: how far they are apart, and how much was bent for it.

Of two maps between nearly isometric shapes, one may preserve distances, the other the details of
the surface. So a fit has several measures of different kinds, with unknown scales. Were their
errors Gaussian with unknown variances, the likelihood of a map would be the product of the inverse
mean squares: the score is the sum of the logarithms.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.functional_maps import mutual_nearest_points
from solver.registration.alignment import GLOBAL, Alignment, Pairs
from solver.registration.surface import Samples, commute_times

_MOST_STRAIN = 2.0
"""Logarithm of a distortion beyond which it counts no more: the triangle is folded."""

_DISTORTED = "distorted"

LEAST = 1e-6
"""Least measure whose logarithm is taken: those of equal surfaces are rounding errors."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Measures of how well a displaced source fits its target.

    Parameters
    ----------
    values
        Measures by name, each 0 where surfaces are equal, and of first order in what differs.
    only_told
        Those that say how probable an answer is, not which one is better.
    share
        Share of both areas that has a partner, if the surfaces only overlap; else 1.
    occlusion
        Score of what has no partner.
    """

    values: Mapping[str, float]
    only_told: frozenset[str] = frozenset()
    share: float = 1.0
    occlusion: float = 0.0

    @cached_property
    def measures(self) -> dict[str, float]:
        """Logarithms of the measures, by name."""
        return {name: float(np.log(max(one, LEAST))) for name, one in self.values.items()}

    @cached_property
    def score(self) -> float:
        """Mean score over the area; the less, the better.

        Where something is met, it is the sum of the logarithms of the measures.
        """
        met = sum(one for name, one in self.measures.items() if name not in self.only_told)
        return self.share * met + (1.0 - self.share) * self.occlusion

    def also(self, values: Mapping[str, float]) -> "Fit":
        """Return the fit with further measures."""
        return replace(self, values={**self.values, **values})


def numbered(name: str, values: Iterable[float]) -> dict[str, float]:
    """Return a measure of several diffusion times, by its name and their numbers."""
    return {f"{name}_{number}": one for number, one in enumerate(values)}


@dataclass(frozen=True, eq=False)
class LocalFit:
    """The local measures of a fit round each source sample.

    Parameters
    ----------
    densities
        (m, S) what the local measures are means of: apart, half the squares of turned and of
        sheared, stretched, and each of bent.
    pairs
        Nearest neighbours it was measured at.
    """

    densities: FloatArray
    pairs: Pairs


_NONE = np.empty(0, dtype=np.int64)
UNMEASURED = LocalFit(np.empty((0, 0)), Pairs.of_all(_NONE, _NONE))
"""Of what is measured as a whole only."""

_ROOTS = [1, 2]
"""Rows of the densities whose means' roots are the measures."""


def worse_by(ours: FloatArray, theirs: FloatArray) -> FloatArray:
    """(S,) by how much one candidate fits worse than another round each sample.

    Of first order in the difference, the mean is that of the logarithms of the local measures.

    Parameters
    ----------
    ours, theirs
        (m, S) densities of both, in the order of :class:`LocalFit`.
    """
    powers = np.ones(len(ours))
    powers[_ROOTS] = 0.5
    mean = 0.5 * (ours + theirs).mean(axis=1)
    difference: FloatArray = (powers / np.maximum(mean, LEAST)) @ (ours - theirs)
    return difference


def measure_fit(
    source: Samples, target: Samples, alignment: Alignment, *, distances: bool = False
) -> tuple[Fit, LocalFit]:
    """Measure the fit of an aligned source, whatever embedding it was aligned in.

    Parameters
    ----------
    source, target
        S and M samples.
    alignment
        The alignment.
    distances
        Whether the change of distances is measured.

    Returns
    -------
    The fit, and what its local measures are made of. The measures are

    ``apart``
        mean distance in the embedding, of both directions;
    ``turned``
        root mean square distance of unit normals, of both directions;
    ``sheared``
        root of twice the mean logarithm of the conformal distortion of the displacement;
    ``stretched``
        mean logarithm of its change of area, up or down;
    ``bent``, for each diffusion time
        mean change of the mean curvature, of both directions, relative to its mean deviation from
        the median: with strain, this is what the elastic energy of a thin shell is made of (Koiter,
        "On the nonlinear theory of thin elastic shells", 1966);
    ``distorted``
        mean change of commute-time distances between samples, relative to the mean distance. It is
        not local as the others are, and says how probable an answer is, not which one is better:
        animals of different species, and limbs that touch, change distances more than wrong maps.
    """
    displaced = source.surface(alignment.coefficients)
    ours = alignment.embed_source(source, displaced, GLOBAL)
    theirs = alignment.embed_target(target, GLOBAL)
    pairs = Pairs.of_all(*mutual_nearest_points(ours, theirs))
    sheared, stretched = strain(source, alignment)
    normals = displaced[1], target.smoothed(alignment.size)[1]
    densities = np.stack(
        [
            _both_ways(pairs, ours, theirs, _distances),
            _both_ways(pairs, *normals, lambda here, there: 1.0 - (here * there).sum(axis=1)),
            sheared,
            np.abs(stretched),
            *_changes_of_curvature(source, target, pairs),
        ]
    )
    apart, turned, shear, stretch, *bent = np.maximum(densities.mean(axis=1), 0.0).tolist()
    values = {
        "apart": apart,
        "turned": float(np.sqrt(2.0 * turned)),
        "sheared": float(np.sqrt(2.0 * shear)),
        "stretched": stretch,
        **numbered("bent", bent),
    }
    if distances:
        values[_DISTORTED] = _distortion(source, target, pairs.images)
    return Fit(values, frozenset({_DISTORTED})), LocalFit(densities, pairs)


def _both_ways(
    pairs: Pairs,
    here: RealArray,
    there: RealArray,
    compare: Callable[[RealArray, RealArray], RealArray],
) -> FloatArray:
    """(S,) of each source sample, from pairs of both directions, which weigh the same."""
    ours = compare(here, there[pairs.images])
    theirs = np.bincount(pairs.back, compare(here[pairs.back], there), minlength=len(here))
    both: FloatArray = 0.5 * ours + 0.5 * len(here) / len(there) * theirs
    return both


def _distances(points: RealArray, others: RealArray) -> RealArray:
    distances: RealArray = np.linalg.norm(points - others, axis=1)
    return distances


def strain(
    source: Samples, alignment: Alignment, scale: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """(S,) logarithms of the conformal distortion and of the change of area.

    With the first fundamental forms g of the smoothed source and G of the displaced one,
    tr(g⁻¹ G) / (2 √(det G / det g)) is at least 1, and 1 where angles are preserved.

    Parameters
    ----------
    source
        S samples.
    alignment
        Of the source.
    scale
        √area of the source before it is displaced.
    """
    rest = source.smoothed_first_form(alignment.size)
    bent = source.first_form(alignment.coefficients)
    (a, b, c), (p, q, r) = rest, bent
    before, after = (np.maximum(x * z - y * y, 1e-12) for x, y, z in (rest, bent))
    trace = (c * p - 2.0 * b * q + a * r) / before
    ratio = np.sqrt(after / before)
    sheared = np.minimum(np.log(np.maximum(0.5 * trace / ratio, 1.0)), _MOST_STRAIN)
    stretched: FloatArray = np.clip(np.log(ratio / scale**2), -_MOST_STRAIN, _MOST_STRAIN)
    return sheared, stretched


def _changes_of_curvature(source: Samples, target: Samples, pairs: Pairs) -> list[FloatArray]:
    """(S,) changes over the mean deviation from the median, for each diffusion time."""
    found = []
    for here, there in zip(source.curvatures.T, target.curvatures.T, strict=True):
        found.append(_both_ways(pairs, here, there, lambda ours, theirs: np.abs(ours - theirs)))
    spread = np.sqrt(source.deviations * target.deviations)
    return [change / max(one, LEAST) for change, one in zip(found, spread, strict=True)]


def _distortion(source: Samples, target: Samples, images: IntArray) -> float:
    """Change of commute-time distances, as in :func:`measure_fit`."""
    here = source.commute_times
    there = commute_times(target, images[: len(here)])
    return float(np.abs(here - there).mean())
