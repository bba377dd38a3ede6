"""Fit of a registered source to its target: how far they are apart, and how much was bent for it.

Of two maps between nearly isometric shapes, one may preserve distances, the other the details of
the surface. So a fit has several measures of different kinds, with unknown scales. Were their
errors Gaussian with unknown variances, the likelihood of a map would be the product of the inverse
mean squares: the score is the sum of the logarithms.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray, RealArray
from solver.functional_maps import mutual_nearest_points
from solver.registration.alignment import GLOBAL, Alignment, Pairs
from solver.registration.surface import Samples, commute_times

_MOST_STRAIN = 2.0
"""Logarithm of a distortion beyond which it counts no more: the triangle is folded."""

LEAST = 1e-6
"""Least measure whose logarithm is taken: those of equal surfaces are rounding errors."""


@dataclass(frozen=True)
class Measures:
    """Measures of a fit: fields that are positive, or 0 where surfaces are equal."""

    @property
    def measures(self) -> dict[str, float]:
        """Logarithms of the measures, by name; those of several diffusion times are numbered.

        What is ``None`` was not measured, and the share that is met is no measure.
        """
        known: dict[str, float] = {}
        for name, one in vars(self).items():
            if isinstance(one, tuple):
                known |= {f"{name}_{number}": value for number, value in enumerate(one)}
            elif one is not None and name != "share":
                known[name] = one
        return {name: float(np.log(max(one, LEAST))) for name, one in known.items()}

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures; the less, the better."""
        return sum(self.measures.values())


@dataclass(frozen=True)
class Fit(Measures):
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
    distorted
        Mean change of commute-time distances between samples, relative to the mean distance. It
        is not local as the others are, and says how probable an answer is, not which one is better:
        animals of different species, and limbs that touch, change distances more than wrong maps.
        ``None`` where it is not measured.
    """

    apart: float
    turned: float
    sheared: float
    stretched: float
    bent: tuple[float, ...]
    distorted: float | None = None

    @property
    def score(self) -> float:
        """Sum of the logarithms of the local measures; the less, the better."""
        return sum(value for name, value in self.measures.items() if name != "distorted")


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
    The fit, and what its local measures are made of.
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
    fit = Fit(
        apart,
        float(np.sqrt(2.0 * turned)),
        float(np.sqrt(2.0 * shear)),
        stretch,
        tuple(bent),
        _distortion(source, target, pairs.images) if distances else None,
    )
    return fit, LocalFit(densities, pairs)


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
    """Change of commute-time distances, as in :class:`Fit`."""
    here = source.commute_times
    there = commute_times(target, images[: len(here)])
    return float(np.abs(here - there).mean())
