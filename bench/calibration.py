"""Calibration of probabilities: of answers called sure, how many are right, and the reverse."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray

PROBABLY_RIGHT = 0.5
"""Probability above which an answer is more probably right than not, and called sure by tables;
otherwise, it is called doubtful. Stricter is :data:`solver.registration.confidence.SURE`."""

BINS = 5
"""Bins of equal width of the reliability table."""


@dataclass(frozen=True)
class ReliabilityBin:
    """Answers with probabilities in an interval.

    Parameters
    ----------
    least, most
        The interval; the last one includes its end.
    answers
        Their number.
    probability
        Mean of their probabilities, ``None`` without answers.
    right
        Share that is right, ``None`` without answers.
    """

    least: float
    most: float
    answers: int
    probability: float | None
    right: float | None


@dataclass(frozen=True)
class Calibration:
    """How well probabilities of being right agree with being right.

    Parameters
    ----------
    answers
        Their number.
    right
        Share that is right.
    sure
        Share that is called sure.
    right_of_sure
        Share of the sure answers that are right, ``None`` if none is sure.
    doubted_of_wrong
        Share of the wrong answers that are called doubtful, ``None`` if none is wrong.
    brier
        Mean square of the probability minus 1 for right and 0 for wrong answers (Brier, Monthly
        Weather Review 78, 1950): 0 is perfect, 0.25 is that of always saying one half.
    error
        Mean over the bins that have answers of the absolute difference between mean probability
        and share right.
    bins
        The reliability table.
    """

    answers: int
    right: float
    sure: float
    right_of_sure: float | None
    doubted_of_wrong: float | None
    brier: float
    error: float
    bins: tuple[ReliabilityBin, ...]

    def figures(self) -> dict[str, float | None]:
        """Figures for a line of JSON."""
        return {
            "right": self.right,
            "sure": self.sure,
            "right_of_sure": self.right_of_sure,
            "doubted_of_wrong": self.doubted_of_wrong,
            "brier": self.brier,
            "calibration_error": self.error,
        }


def calibration(probability: FloatArray, right: BoolArray) -> Calibration:
    """Compare probabilities with what they announce.

    Parameters
    ----------
    probability
        (P,) in [0, 1], one an answer, at least one.
    right
        (P,) whether the answer is right.
    """
    sure = probability > PROBABLY_RIGHT
    bins = reliability(probability, right)
    away = [
        abs(one.probability - one.right)
        for one in bins
        if one.probability is not None and one.right is not None
    ]
    return Calibration(
        answers=len(right),
        right=float(right.mean()),
        sure=float(sure.mean()),
        right_of_sure=_share(right[sure]),
        doubted_of_wrong=_share(~sure[~right]),
        brier=float(np.mean((probability - right) ** 2)),
        error=float(np.mean(away)),
        bins=bins,
    )


def reliability(
    probability: FloatArray, right: BoolArray, bins: int = BINS
) -> tuple[ReliabilityBin, ...]:
    """Sort answers into bins of equal width by their probability."""
    bounds = np.linspace(0.0, 1.0, bins + 1)
    place = np.minimum((probability * bins).astype(np.int64), bins - 1)
    rows = []
    for number in range(bins):
        inside = place == number
        rows.append(
            ReliabilityBin(
                float(bounds[number]),
                float(bounds[number + 1]),
                int(inside.sum()),
                float(probability[inside].mean()) if inside.any() else None,
                _share(right[inside]),
            )
        )
    return tuple(rows)


def print_calibration(title: str, found: Calibration) -> None:
    """Print the reliability table and the figures below it."""
    print(f"\n{title}: {found.answers} answers, {found.right:.1%} right")
    print(f"{'probability':>13}{'answers':>9}{'mean':>8}{'right':>8}")
    for one in found.bins:
        span = f"{one.least:.1f} to {one.most:.1f}"
        print(f"{span:>13}{one.answers:9}{shown(one.probability):>8}{shown(one.right):>8}")
    print(
        f"right of those called sure {shown(found.right_of_sure)}   "
        f"called doubtful of the wrong ones {shown(found.doubted_of_wrong)}   "
        f"Brier score {found.brier:.4f}   calibration error {found.error:.4f}"
    )


def shown(value: float | None) -> str:
    """Three digits, or a dash where there is no figure."""
    return "-" if value is None else f"{value:.3f}"


def _share(said: BoolArray) -> float | None:
    return float(said.mean()) if len(said) else None
