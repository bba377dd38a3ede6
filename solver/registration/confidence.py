"""Confidence of an answer: the probability that it is right, and the reasons for doubt."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Confidence:
    """Confidence of an answer.

    Parameters
    ----------
    probability
        Calibrated probability, in [0, 1], that the answer is right: that its mean geodesic error
        is below a tenth of the square root of the area.
    reasons
        Reasons for doubt in words, such as "the mirror image fits nearly as well"; empty when
        there are none.
    """

    probability: float
    reasons: tuple[str, ...]
