"""Confidence in the registration of a part."""

from collections.abc import Sequence
from types import MappingProxyType

from solver.registration.confidence import (
    LITTLE,
    SURE,
    Confidence,
    margin_of,
    measured_margin,
    probability_of,
    reasons_for_doubt,
)
from solver.registration.partial.fit import RefinedPartFit
from solver.registration.partial.partiality import Partiality

_EXACT = -20.0
"""Score below which surfaces are equal but for their sampling. A brick fits itself turned round
with -21, a torus by any angle with -23; a clean generated person in another pose has -25, and the
next best answer -18; halves of scanned people have -12 to -16, and -11 to -15."""

_COVERED = 0.25
"""Share of both areas below which the probability falls with it: all that it was fitted to cover
more, and any small patch fits somewhere."""


def part_confidence(
    fits: Sequence[RefinedPartFit],
    covered: float,
    partiality: Partiality,
    complete: bool = True,
) -> Confidence:
    """Confidence in the first of some registrations that differ.

    Parameters
    ----------
    fits
        The best first.
    covered
        Share of the area that has a partner, of the surface that has less.
    partiality
        What the surfaces are to one another.
    complete
        Whether all candidates were tried.
    """
    best, margin = fits[0], margin_of([one.score for one in fits])
    measures = {
        **best.measures,
        "share": best.share,
        "score": best.score,
        "margin": measured_margin(margin),
    }
    # Where nothing overlaps, there is no answer that could be right.
    regression = partiality.weights, partiality.intercept
    probability = probability_of(measures, *regression) if best.share else 0.0
    reasons = reasons_for_doubt(probability, margin, complete)
    probability *= min(covered / _COVERED, 1.0)
    if covered < _COVERED and probability < SURE:
        reasons = (LITTLE, *reasons)
    found = Confidence(probability, reasons, MappingProxyType(measures))
    return found.among([one.score for one in fits], _EXACT)
