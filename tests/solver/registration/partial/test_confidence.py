"""Confidence in the registration of a part."""

import pytest

from solver.registration.confidence import LITTLE, MISFIT
from solver.registration.fit import Fit, numbered
from solver.registration.partial.confidence import part_confidence
from solver.registration.partial.partiality import OF_OVERLAP, OF_PART, Partiality

GOOD = Fit(
    {"apart": 0.01, "turned": 0.2, "strained": 0.1, "bent_0": 0.3, "bent_1": 0.2, "distorted": 0.1}
)
NOTHING = Fit({}, share=0.0)


@pytest.mark.parametrize("kind", [OF_OVERLAP, OF_PART])
def test_it_grows_with_the_margin(kind: Partiality) -> None:
    others = [GOOD.also({"apart": factor * 0.01}) for factor in (1.0, 1.5, 2.5)]
    said = [part_confidence([GOOD, one], 0.5, kind).probability for one in others]
    assert said[0] < said[1] < said[2] <= part_confidence([GOOD], 0.5, kind).probability


def test_a_part_that_fits_better_is_more_probable() -> None:
    worse = GOOD.also(numbered("bent", (0.6, 0.4)))
    said = [part_confidence([one], 0.5, OF_PART).probability for one in (worse, GOOD)]
    assert said[0] < said[1]


def test_surfaces_that_do_not_overlap_are_not_matched_rightly() -> None:
    found = part_confidence([NOTHING], 0.0, OF_OVERLAP)
    assert found.probability == 0.0
    assert MISFIT in found.reasons


@pytest.mark.parametrize("kind", [OF_OVERLAP, OF_PART])
def test_a_small_patch_says_little(kind: Partiality) -> None:
    known = part_confidence([GOOD], 0.4, kind)
    assert known.reasons == ()
    assert part_confidence([GOOD], 0.25, kind).probability == known.probability
    small = part_confidence([GOOD], 0.05, kind)
    assert small.probability == pytest.approx(known.probability / 5)
    assert small.reasons == (LITTLE,)
