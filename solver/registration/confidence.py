"""Confidence in a registration: a calibrated probability, and reasons for doubt in words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from solver.registration.fit import Fit


@dataclass(frozen=True)
class Regression:
    """Logistic regression of the probability that an answer is right.

    Parameters
    ----------
    weights
        Of measures, by name.
    intercept
        Of the logit.
    """

    weights: Mapping[str, float]
    intercept: float

    def probability(self, measures: Mapping[str, float]) -> float:
        """Return the probability by measures, which may be more than are asked."""
        weighted = (weight * measures[name] for name, weight in self.weights.items())
        return float(1.0 / (1.0 + np.exp(-(self.intercept + sum(weighted)))))


_OF_FIT = Regression(
    MappingProxyType({"turned": -8.85, "bent_1": -4.06, "distorted": -2.05, "margin": 2.66}), -18.7
)
"""Logistic regression on 120 generated pairs, of which 90 are right: ``python -m
bench.confidence_fit``. All measures together do no better on pairs held out."""

_OF_REFINED = Regression(MappingProxyType({"refined_score": -4.26}), -30.0)
"""The same of a refined fit, and of a choice between two: the product of both probabilities, fitted
by a script to the generated answers of ``--seed 5 --pairs 60`` and ``--seed 7 --pairs 90`` that
were refined, 168 of two versions of the search; 129 are right."""

_EQUAL = Regression(MappingProxyType({}), -2.2)
_OF_CHOICE = {
    name: replace(_EQUAL, weights=MappingProxyType({name: weight}))
    for name, weight in (("refined_margin", 34.0), ("rivals_margin", 17.0))
}
"""Where two fit equally, most answers are wrong: the right one, where it was found, is clearly the
best. On few vertices a difference of 0.15 tells. On all, where scores differ about twice as much,
half the weight is on the side of doubt: a fit to 23 such answers, of which six are right, gives
35."""

RIGHT_ERROR = 0.1
"""Mean geodesic error over √area up to which an answer counts as right. Distances in space are
compared with it, too: they are never greater than geodesic ones."""

SURE = 0.9
"""Probability from which no reason for doubt is given."""

_OPENED = 0.8
"""Share of the probability that is left of an answer on opened surfaces, which is never sure: a
ring can be opened until it fits a ball, and of eight such pairs of TOPKIDS one is wrong."""

_EITHER = 0.5
"""Share of the probability that is left where one of two may be wrong."""

_LIKELY = 0.5
"""Probability from which an answer is rather right than wrong."""

RIVAL_MARGIN = 0.25
"""Difference of scores below which another correspondence fits nearly as well: on generated pairs,
half of the answers by less are wrong."""

EXACT = -15.0
REFINED_EXACT = -12.0
"""Scores of fits in eigenfunctions, and of those refined on few vertices, below which surfaces are
equal but for their sampling: which of two such fits is better says nothing. A ball fits itself
turned by any angle with -18 and -14, a starfish turned by an arm with -16 and -14; a generated
person in another pose fits with -13."""

RIVAL = "another correspondence, such as an exchange of two sides, fits nearly as well"
MISFIT = "large parts of the surfaces do not fit one another"
REFLECTED = (
    "only the mirror image of the source fits: one of the two seems to be reflected in space"
)
CONTRADICTED = "landmarks that were given are far from where the surfaces fit"
OPENED = "parts that seem to touch were cut apart, and what was cut out is not compared"
LITTLE = "little of the surfaces has a partner, and a small patch fits in many places"
UNFINISHED = "the time limit ended the search"


@dataclass(frozen=True)
class Confidence:
    """Confidence in an answer.

    Parameters
    ----------
    probability
        Calibrated probability in [0, 1] that the answer is right: that its mean geodesic error is
        at most :data:`RIGHT_ERROR`.
    reasons
        Reasons for doubt in words; empty when sure, unless the time limit ended the search.
    measures
        What the probability is computed from, by name.
    """

    probability: float
    reasons: tuple[str, ...]
    measures: Mapping[str, float] = field(default_factory=dict)

    @property
    def margin(self) -> float:
        """How much greater the score of the best other candidate is; 0 if it is less, at most 1."""
        return self.measures["margin"]

    @property
    def refined_score(self) -> float | None:
        """Score of the refined fit; ``None`` where candidates were not refined to be compared."""
        return self.measures.get("refined_score")

    @property
    def is_unfinished(self) -> bool:
        """Whether the time limit ended the search."""
        return UNFINISHED in self.reasons

    @property
    def is_contradicted(self) -> bool:
        """Whether landmarks contradict the answer."""
        return CONTRADICTED in self.reasons

    @property
    def is_likely(self) -> bool:
        """Whether the answer is rather right than wrong."""
        return self.probability >= _LIKELY

    @property
    def is_sure(self) -> bool:
        """Whether there is no reason for doubt."""
        return self.probability >= SURE

    def among(self, scores: Sequence[float], exact: float) -> "Confidence":
        """Return the confidence in the first of some answers, of which others may be exact, too.

        Then it is at most that in one of two that fit equally.

        Parameters
        ----------
        scores
            The least first.
        exact
            Score below which a fit is exact.
        """
        if min(scores[1:], default=exact) >= exact:
            return self
        reasons = tuple(dict.fromkeys((RIVAL, *self.reasons)))
        probability = min(self.probability, _EQUAL.probability({}))
        return replace(self, probability=probability, reasons=reasons)

    def at_least(self, probability: float) -> "Confidence":
        """Return the confidence in an answer that is right with a probability by other evidence.

        Parameters
        ----------
        probability
            By the other evidence alone; the greater one counts.
        """
        surest = max(self.probability, probability)
        unfinished = (UNFINISHED,) if self.is_unfinished else ()
        reasons = self.reasons if surest < SURE else unfinished
        return replace(self, probability=surest, reasons=reasons)

    def of_reflection(self) -> "Confidence":
        """Return the confidence in an answer of the reflected source.

        It is halved: where a body is symmetric, its mirror image fits as well as itself.
        """
        return self._reduced(_EITHER, REFLECTED)

    def against_landmarks(self) -> "Confidence":
        """Return the confidence in an answer that contradicts landmarks.

        It is halved: either may be wrong.
        """
        return self._reduced(_EITHER, CONTRADICTED)

    def of_opened(self) -> "Confidence":
        """Return the confidence in an answer on surfaces that were opened where parts touch."""
        return self._reduced(_OPENED, OPENED)

    def _reduced(self, share: float, reason: str) -> "Confidence":
        return replace(self, probability=share * self.probability, reasons=(reason, *self.reasons))


def margin_of(scores: Sequence[float]) -> float:
    """How much greater the least of the other scores is than the first; infinite if it is alone."""
    return min(scores[1:], default=float("inf")) - scores[0]


def measured_margin(margin: float) -> float:
    """Return a margin as a measure: none below 0, as of rivals, and none beyond 1."""
    return min(max(margin, 0.0), 1.0)


def confidence_of(fit: Fit, margin: float, complete: bool = True) -> Confidence:
    """Confidence in a registration.

    Parameters
    ----------
    fit
        Of the chosen candidate.
    margin
        How much greater the score of the best other candidate is; infinite if there is none.
    complete
        Whether all candidates were tried.
    """
    return confidence_by({**fit.measures, "score": fit.score}, _OF_FIT, margin, complete)


def confidence_by(
    measures: Mapping[str, float], regression: Regression, margin: float, complete: bool = True
) -> Confidence:
    """Confidence in a registration by a regression on its measures and its margin.

    Parameters
    ----------
    measures
        All but the margin, by name.
    regression
        Of the probability.
    margin, complete
        As for :func:`confidence_of`.
    """
    measures = {**measures, "margin": measured_margin(margin)}
    probability = regression.probability(measures)
    reasons = _reasons_for_doubt(probability, margin, complete)
    return Confidence(probability, reasons, MappingProxyType(measures))


def refined_confidence(
    known: Confidence,
    fit: Fit,
    margin: float,
    *,
    among_rivals: bool = False,
    complete: bool = True,
) -> Confidence:
    """Confidence in a registration that was refined on few vertices.

    Parameters
    ----------
    known
        In the best before they were refined, whose measures are kept.
    fit
        Of the chosen candidate.
    margin
        How much greater the score of the best other candidate is; infinite if there is none.
    among_rivals
        Whether the scores are those of rivals, refined with all vertices.
    complete
        Whether all candidates were tried.
    """
    choice = "rivals_margin" if among_rivals else "refined_margin"
    measures = {
        **known.measures,
        **{f"refined_{name}": one for name, one in fit.measures.items()},
        "refined_score": fit.score,
        choice: measured_margin(margin),
    }
    fitting = _OF_REFINED.probability(measures)
    choosing = _OF_CHOICE[choice].probability(measures)
    probability = fitting * choosing
    doubtful = probability < SURE
    reasons = (
        *((RIVAL,) if doubtful and choosing <= max(fitting, SURE) else ()),
        *((MISFIT,) if doubtful and fitting <= max(choosing, SURE) else ()),
        *(() if complete else (UNFINISHED,)),
    )
    return Confidence(probability, reasons, MappingProxyType(measures))


def _reasons_for_doubt(probability: float, margin: float, complete: bool) -> tuple[str, ...]:
    """Return reasons in words; none when sure, unless the search has ended before its time.

    Parameters
    ----------
    probability
        That the answer is right.
    margin
        How much greater the score of the best other candidate is.
    complete
        Whether all candidates were tried.
    """
    reasons = []
    if probability < SURE:
        rival = margin < RIVAL_MARGIN
        if rival:
            reasons.append(RIVAL)
        if probability < _LIKELY or not rival:
            reasons.append(MISFIT)
    if not complete:
        reasons.append(UNFINISHED)
    return tuple(reasons)
