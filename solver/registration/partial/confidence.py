"""Confidence in the registration of a part."""

from collections.abc import Mapping, Sequence
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

_WEIGHTS: Mapping[str, float] = MappingProxyType({"score": -0.50, "margin": 4.3})
_INTERCEPT = -8.0
"""Logistic regression on 196 generated people, of which 186 are right, corrected to five right ones
for each wrong one, as users' parts may be harder: the mean of those of ``python -m bench.partial
--fit`` for ``--first 300 --count 96`` and ``--first 500 --count 100``, whose intercepts are for as
many wrong ones as right ones, plus log 5."""

_WEIGHTS_OF_OVERLAP: Mapping[str, float] = MappingProxyType({"margin": 5.3})
_INTERCEPT_OF_OVERLAP = -0.86
"""The same of surfaces that overlap, corrected to seven right ones for each three wrong ones: of
``--both --count 22``, and of 18 of ``--both --opposite --detected`` as matched before; 32 of these
40 generated pairs are right. Wrong answers fit as well as right ones, so that only the margin
tells: without any, an answer is doubtful."""

_EXACT = -20.0
"""Score below which surfaces are equal but for their sampling. A brick fits itself turned round
with -21, a torus by any angle with -23; a clean generated person in another pose has -25, and the
next best answer -18; halves of scanned people have -12 to -16, and -11 to -15."""

_COVERED = 0.25
"""Share of both areas below which the probability falls with it: all that it was fitted to cover
more, and any small patch fits somewhere."""


def part_confidence(
    fits: Sequence[RefinedPartFit], covered: float, entire: bool = True, complete: bool = True
) -> Confidence:
    """Confidence in the first of some registrations that differ.

    Parameters
    ----------
    fits
        The best first.
    covered
        Share of the area that has a partner, of the surface that has less.
    entire
        Whether every point of the part has a partner.
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
    weights = _WEIGHTS if entire else _WEIGHTS_OF_OVERLAP
    intercept = _INTERCEPT if entire else _INTERCEPT_OF_OVERLAP
    # Where nothing overlaps, there is no answer that could be right.
    probability = probability_of(measures, weights, intercept) if best.share else 0.0
    reasons = reasons_for_doubt(probability, margin, complete)
    probability *= min(covered / _COVERED, 1.0)
    if covered < _COVERED and probability < SURE:
        reasons = (LITTLE, *reasons)
    found = Confidence(probability, reasons, MappingProxyType(measures))
    return found.among([one.score for one in fits], _EXACT)
