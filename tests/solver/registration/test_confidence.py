"""Confidence: a probability that agrees with its reasons."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.registration.confidence import (
    MISFIT,
    RIVAL,
    UNFINISHED,
    Confidence,
    confidence_of,
    refined_confidence,
)
from solver.registration.fit import Fit

MEASURE = st.floats(1e-3, 3.0)
NAMES = "apart", "turned", "sheared", "stretched", "bent_0", "bent_1", "distorted"
REFINED_NAMES = "apart", "turned", "strained"


def fit_of(*measures: float) -> Fit:
    return Fit(dict(zip(NAMES, measures, strict=True)), frozenset({"distorted"}))


def refined_of(*measures: float) -> Fit:
    return Fit(dict(zip(REFINED_NAMES, measures, strict=True)))


MEASURES = st.builds(fit_of, *[MEASURE] * len(NAMES))
MARGINS = st.floats(-1.0, 5.0) | st.just(np.inf)

WORSE = 1.1, 1.5, 3.0


def worse_than(fit: Fit, factor: float) -> Fit:
    return replace(fit, values={name: factor * one for name, one in fit.values.items()})


@given(MEASURES, MARGINS)
def test_reasons_agree_with_the_probability(fit: Fit, margin: float) -> None:
    found = confidence_of(fit, margin)
    assert 0.0 <= found.probability <= 1.0
    assert bool(found.reasons) == (found.probability < 0.9)
    assert set(found.reasons) <= {RIVAL, MISFIT}
    assert all(np.isfinite(value) for value in found.measures.values())


@given(MEASURES, MARGINS, st.sampled_from(WORSE))
def test_a_better_fit_is_more_probable(fit: Fit, margin: float, factor: float) -> None:
    better, worse = confidence_of(fit, margin), confidence_of(worse_than(fit, factor), margin)
    assert worse.measures["score"] > better.measures["score"]
    assert worse.probability <= better.probability


@given(MEASURES, MARGINS, MARGINS)
def test_a_greater_margin_is_more_probable(fit: Fit, one: float, other: float) -> None:
    less, more = (confidence_of(fit, margin) for margin in sorted((one, other)))
    assert less.probability <= more.probability


def test_a_close_rival_and_a_misfit_are_told_apart() -> None:
    bad = fit_of(2.0, *[1.0] * 6)
    assert confidence_of(bad, np.inf).reasons == (MISFIT,)
    assert confidence_of(bad, 0.0).reasons == (RIVAL, MISFIT)


REFINED = st.builds(refined_of, *[MEASURE] * len(REFINED_NAMES))


@given(MEASURES, REFINED, MARGINS, st.booleans())
def test_refined_reasons_agree_with_the_probability(
    fit: Fit, refined: Fit, margin: float, among_rivals: bool
) -> None:
    known = confidence_of(fit, 1.0)
    found = refined_confidence(known, refined, margin, among_rivals=among_rivals)
    assert bool(found.reasons) == (found.probability < 0.9)
    assert known.measures.items() <= found.measures.items()
    name = "rivals_margin" if among_rivals else "refined_margin"
    assert found.measures[name] == min(max(margin, 0.0), 1.0)
    # Without rivals, or with less strain, it is more probable.
    assert found.probability <= refined_confidence(known, refined, np.inf).probability
    stiffer = refined.also({"strained": 0.5 * refined.values["strained"]})
    assert (
        found.probability
        <= refined_confidence(known, stiffer, margin, among_rivals=among_rivals).probability
    )


def test_of_two_that_fit_equally_well_neither_is_likely_to_be_right() -> None:
    exact = refined_of(1e-3, 1e-2, 1e-3)
    known = confidence_of(fit_of(*[1e-3] * 7), 0.0)
    assert refined_confidence(known, exact, np.inf).reasons == ()
    found = refined_confidence(known, exact, 0.0)
    assert found.probability <= 0.5
    assert found.reasons == (RIVAL,)
    unfinished = refined_confidence(known, exact, np.inf, complete=False)
    assert unfinished.reasons == (UNFINISHED,)


def test_a_search_without_time_says_so() -> None:
    good = fit_of(*[1e-3] * 7)
    assert confidence_of(good, np.inf).reasons == ()
    unfinished = confidence_of(good, np.inf, complete=False)
    assert unfinished.reasons == (UNFINISHED,)
    assert unfinished.probability == pytest.approx(confidence_of(good, np.inf).probability)


def test_other_evidence_dispels_doubts_if_it_is_sure() -> None:
    doubted = Confidence(0.3, (MISFIT,))
    assert doubted.at_least(0.95) == Confidence(0.95, ())
    assert doubted.at_least(0.5) == Confidence(0.5, (MISFIT,))
    assert doubted.at_least(0.1) == doubted
    unfinished = Confidence(0.3, (MISFIT, UNFINISHED))
    assert unfinished.at_least(0.95) == Confidence(0.95, (UNFINISHED,))
