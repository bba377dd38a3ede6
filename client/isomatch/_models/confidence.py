"""Confidence of an answer: the probability that it is right, and the reasons for doubt."""

from typing import Final

from pydantic import FiniteFloat

from isomatch._models.answer import Answer

SURE: Final = 0.9
"""Probability of being right from which there are no reasons for doubt."""
LIKELY_RIGHT: Final = 0.5
"""Probability of being right above which an answer is not in doubt."""


class Confidence(Answer):
    """Confidence of an answer; ``str`` has it in a short phrase.

    Attributes
    ----------
    probability
        Calibrated probability, in [0, 1], that the answer is right: that its mean geodesic error
        is below a tenth of the square root of the area.
    reasons
        Reasons for doubt in words, such as ``"the mirror image fits nearly as well"``; empty when
        there are none.

    Examples
    --------
    >>> print(match.confidence)
    in doubt, confidence 31 %: the mirror image fits nearly as well
    """

    probability: FiniteFloat
    reasons: tuple[str, ...]

    @property
    def in_doubt(self) -> bool:
        """Whether the answer is not more probably right than wrong."""
        return self.probability <= LIKELY_RIGHT

    def __str__(self) -> str:
        # No calibration is as sure as 0 or 100 per cent.
        percent = min(max(round(100.0 * self.probability), 1), 99)
        said = f"confidence {percent} %"
        if self.in_doubt:
            said = f"in doubt, {said}"
        return f"{said}: {'; '.join(self.reasons)}" if self.reasons else said
