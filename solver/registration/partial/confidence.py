"""Confidence in the registration of a part."""

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

from solver.registration.confidence import (
    LITTLE,
    SURE,
    Confidence,
    Regression,
    confidence_by,
    margin_of,
)
from solver.registration.fit import Fit
from solver.registration.partial.partiality import Partiality

_EXACT = -20.0
"""Score below which surfaces are equal but for their sampling. A brick fits itself turned round
with -21, a torus by any angle with -23; a clean generated person in another pose has -25, and the
next best answer -18; halves of scanned people have -12 to -16, and -11 to -15."""

_COVERED = 0.25
"""Share of both areas below which the probability falls with it: all that it was fitted to cover
more, and any small patch fits somewhere."""

_NOTHING = Regression(MappingProxyType({}), float("-inf"))
"""Where nothing overlaps, there is no answer that could be right."""


def part_confidence(
    fits: Sequence[Fit],
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
    best, scores = fits[0], [one.score for one in fits]
    found = confidence_by(
        {**best.measures, "share": best.share, "score": best.score},
        partiality.regression if best.share else _NOTHING,
        margin_of(scores),
        complete,
    )
    probability, reasons = found.probability * min(covered / _COVERED, 1.0), found.reasons
    if covered < _COVERED and probability < SURE:
        reasons = (LITTLE, *reasons)
    return replace(found, probability=probability, reasons=reasons).among(scores, _EXACT)
