"""Fit of a displaced whole to a part of it: as :mod:`solver.registration.fit`, where they meet."""

from dataclasses import dataclass

import numpy as np

from solver.registration.alignment import Alignment
from solver.registration.fit import strain
from solver.registration.partial.alignment import (
    IN_SPACE,
    WEIGHTS,
    PartPairs,
    PartSamples,
    embed,
    find_pairs,
)
from solver.registration.surface import Samples, mean_curvatures

_LEAST = 1e-6


@dataclass(frozen=True)
class PartFit:
    """Measures of a displaced whole and a part, each 0 where the part was cut out of the whole.

    Parameters
    ----------
    apart
        Mean distance of the part from the whole in the embedding, over √area of the part.
    turned
        Root mean square distance of unit normals.
    sheared, stretched
        As of :class:`.Fit`, where the whole is covered.
    """

    apart: float
    turned: float
    sheared: float
    stretched: float

    @property
    def measures(self) -> dict[str, float]:
        """Logarithms of the measures, by name."""
        return {name: float(np.log(max(one, _LEAST))) for name, one in vars(self).items()}

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures; the less, the better."""
        return sum(self.measures.values())


def measure_part_fit(
    whole: Samples, part: PartSamples, alignment: Alignment, scale: float
) -> PartFit:
    """Measure the fit of a displaced whole to a part.

    Parameters
    ----------
    whole, part
        Samples.
    alignment
        Of them.
    scale
        √area of the whole in the part's unit.
    """
    pairs = find_pairs(whole, part, alignment, scale, IN_SPACE)
    ours, theirs = embed(whole, part, alignment, scale, IN_SPACE)
    apart = np.linalg.norm(ours[pairs.back] - theirs, axis=1).mean() * scale
    normals = whole.surface(alignment.coefficients)[1][pairs.back]
    turned = 1.0 - (normals * part.normals).sum(axis=1)
    met = np.bincount(pairs.back, minlength=len(whole)) + pairs.covered
    sheared, stretched = strain(whole, alignment, scale)
    return PartFit(
        float(apart),
        float(np.sqrt(2.0 * max(turned.mean(), 0.0))),
        float(np.sqrt(2.0 * (met * sheared).sum() / met.sum())),
        float((met * np.abs(stretched)).sum() / met.sum()),
    )


def scale_of(whole: Samples, part: PartSamples, alignment: Alignment, scale: float) -> float:
    """√area of the whole in the part's unit: median stretch of the whole where it is covered."""
    pairs = find_pairs(whole, part, alignment, scale, WEIGHTS)
    _, stretched = strain(whole, alignment, scale)
    return scale * float(np.exp(0.5 * np.median(stretched[pairs.rows])))


@dataclass(frozen=True)
class RefinedPartFit:
    """Measures of a whole that was displaced as rigidly as possible, each 0 for a part cut out.

    They tell candidates apart that eigenfunctions fit equally well: on 46 generated and scanned
    parts, 44 of the right ones are the best by these, and 31 by :class:`PartFit`.

    Parameters
    ----------
    apart
        Mean distance of the part from the displaced whole, over √area of the part.
    turned
        Root mean square distance of unit normals.
    strained
        Mean strain of the edges of the whole.
    bent
        For each diffusion time, mean change of the mean curvature, as of :class:`.Fit`.
    """

    apart: float
    turned: float
    strained: float
    bent: tuple[float, ...]

    @property
    def measures(self) -> dict[str, float]:
        """Logarithms of the measures, by name."""
        several = {f"bent_{number}": one for number, one in enumerate(self.bent)}
        known = {"apart": self.apart, "turned": self.turned, "strained": self.strained, **several}
        return {name: float(np.log(max(one, _LEAST))) for name, one in known.items()}

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures; the less, the better."""
        return sum(self.measures.values())


def changes_of_curvature(
    whole: Samples, part: Samples, pairs: PartPairs, scale: float
) -> tuple[float, ...]:
    """Mean changes of the curvature from the whole to the part, over the mean deviation there.

    Parameters
    ----------
    whole, part
        Samples; those of the part are more than the pairs', or as many.
    pairs
        Of them.
    scale
        √area of the whole in the part's unit.
    """
    here = whole.curvatures[pairs.back]
    there = mean_curvatures(part.first(len(pairs.back)), scale**2)
    changes = np.abs(here - there).mean(axis=0) / np.maximum(whole.deviations, _LEAST)
    return tuple(changes.tolist())
