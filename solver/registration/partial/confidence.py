"""Confidence in the registration of a part."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from solver.registration.confidence import Confidence, probability_of, reasons_for_doubt
from solver.registration.partial.fit import RefinedPartFit

_WEIGHTS: Mapping[str, float] = MappingProxyType({"score": -1.28, "margin": 1.60})
_INTERCEPT = -10.96
"""Logistic regression on 80 parts generated as those of :mod:`bench.partial`; 60 are right. All
measures together do no better on pairs held out."""


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
    probability = probability_of(measures, _WEIGHTS, _INTERCEPT)
    reasons = reasons_for_doubt(probability, margin, complete)
    return Confidence(probability, reasons, MappingProxyType(measures))
