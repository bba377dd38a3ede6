"""Confidence in the registration of a part."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from solver.registration.confidence import Confidence, probability_of, reasons_for_doubt
from solver.registration.partial.fit import RefinedPartFit

_WEIGHTS: Mapping[str, float] = MappingProxyType({"score": -0.63, "margin": 2.80})
_INTERCEPT = -6.03
"""Logistic regression on 112 parts generated as those of :mod:`bench.partial`; 82 are right. Held
out, the Brier score is 0.16, and 0.16 of all measures together."""

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
    best, *others = fits
    margin = min((one.score for one in others), default=float("inf")) - best.score
    measures = {
        **best.measures,
        "share": best.share,
        "score": best.score,
        "margin": min(max(margin, 0.0), 1.0),
    }
    weights = _WEIGHTS if entire else _WEIGHTS_OF_OVERLAP
    intercept = _INTERCEPT if entire else _INTERCEPT_OF_OVERLAP
    probability = probability_of(measures, weights, intercept)
    reasons = reasons_for_doubt(probability, margin, complete)
    return Confidence(probability, reasons, MappingProxyType(measures))
