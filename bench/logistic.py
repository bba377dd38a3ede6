"""Logistic regression of right answers on measures: the weights of a confidence."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import expit
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import StratifiedKFold

from solver.arrays import BoolArray, FloatArray

STRENGTH = 1.0
"""Weight of the squared standardised weights in the loss, against the sum over answers."""

FOLDS = 5
"""Parts of the answers of which each is predicted by a fit to the others."""


@dataclass(frozen=True)
class LogisticFit:
    """The probability 1 / (1 + exp(-(intercept + Σ weight · measure))).

    Parameters
    ----------
    weights
        By the measure's name, per its own unit.
    intercept
        Logit of the probability where all measures are 0.
    effects
        Weights of measures divided by their standard deviation, to be compared with one another.
    """

    weights: Mapping[str, float]
    intercept: float
    effects: Mapping[str, float]

    def probability(self, measures: FloatArray) -> FloatArray:
        """(P,) probabilities of the rows of (P, M) measures, in the order of `weights`."""
        logits = self.intercept + measures @ np.array(list(self.weights.values()))
        found: FloatArray = expit(logits)
        return found


def fit_logistic(
    names: list[str],
    measures: FloatArray,
    right: BoolArray,
    strength: float = STRENGTH,
    *,
    balanced: bool = False,
) -> LogisticFit:
    """Fit weights of least logistic loss.

    Parameters
    ----------
    names
        Of the measures.
    measures
        (P, M) finite. They are standardised for the fit, so that `strength` means the same for
        each; one that is constant gets weight 0.
    right
        (P,) with right and wrong answers.
    strength
        Of the penalty on large weights. Without it, weights grow without limit where measures
        separate right answers from wrong ones.
    balanced
        Whether the intercept is corrected to that of as many right as wrong answers (King and Zeng,
        "Logistic regression in rare events data", Political Analysis 9, 2001).
    """
    mean, deviation = measures.mean(axis=0), measures.std(axis=0)
    scale = np.where(deviation > 0.0, deviation, np.inf)
    model = LogisticRegression(C=1.0 / strength, max_iter=10_000, tol=1e-8)
    model.fit((measures - mean) / scale, right)
    effects = model.coef_[0]
    weights = effects / scale
    prior = np.log(right.sum() / (~right).sum()) if balanced else 0.0
    return LogisticFit(
        weights=dict(zip(names, weights.tolist(), strict=True)),
        intercept=float(model.intercept_[0] - weights @ mean - prior),
        effects=dict(zip(names, effects.tolist(), strict=True)),
    )


def held_out_probability(
    names: list[str], measures: FloatArray, right: BoolArray, strength: float = STRENGTH
) -> FloatArray:
    """(P,) probability of each answer, by a fit to the other parts of the answers.

    Parameters
    ----------
    names, measures, right, strength
        As for :func:`fit_logistic`, with at least `FOLDS` right and as many wrong answers.
    """
    found = np.empty(len(right))
    folds = StratifiedKFold(FOLDS, shuffle=True, random_state=0)
    for learned, left in folds.split(measures, right):
        fit = fit_logistic(names, measures[learned], right[learned], strength)
        found[left] = fit.probability(measures[left])
    return found
