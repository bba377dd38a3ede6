"""Confidence in the registration of a part."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from solver.registration.confidence import (
    Confidence,
    margin_of,
    measured_margin,
    probability_of,
    reasons_for_doubt,
)
from solver.registration.partial.fit import RefinedPartFit

_WEIGHTS: Mapping[str, float] = MappingProxyType({"score": -0.78, "margin": 3.13})
_INTERCEPT = -9.73
"""Logistic regression on 96 generated people, of which 85 are right, corrected to as many right as
wrong ones: ``python -m bench.partial --count 96 --first 300 --fit``. Users' parts may be harder."""

_WEIGHTS_OF_OVERLAP: Mapping[str, float] = MappingProxyType({"margin": 3.19})
_INTERCEPT_OF_OVERLAP = -0.39
"""Of surfaces that overlap, on 41 answers to 30 pairs generated as those of ``python -m
bench.partial --both``; 23 are right. Wrong answers fit as well as right ones, so that only the
margin tells, and only answers of the greatest margin are sure."""


def part_confidence(
    fits: Sequence[RefinedPartFit], entire: bool = True, complete: bool = True
) -> Confidence:
    """Confidence in the first of some registrations that differ.

    Parameters
    ----------
    fits
        The best first.
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
    probability = probability_of(measures, weights, intercept)
    reasons = reasons_for_doubt(probability, margin, complete)
    return Confidence(probability, reasons, MappingProxyType(measures))
