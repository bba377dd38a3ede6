"""Confidence in the registration of a part."""

from dataclasses import replace

import pytest

from solver.registration.confidence import MISFIT
from solver.registration.partial.confidence import part_confidence
from solver.registration.partial.fit import RefinedPartFit

GOOD = RefinedPartFit(0.01, 0.2, 0.1, (0.3, 0.2), 0.1)


@pytest.mark.parametrize("entire", [False, True])
def test_it_grows_with_the_margin(entire: bool) -> None:
    others = [replace(GOOD, apart=factor * GOOD.apart) for factor in (1.0, 1.5, 2.5)]
    said = [part_confidence([GOOD, one], entire).probability for one in others]
    assert said[0] < said[1] < said[2] <= part_confidence([GOOD], entire).probability


def test_a_part_that_fits_better_is_more_probable() -> None:
    worse = replace(GOOD, bent=(0.6, 0.4))
    assert part_confidence([worse]).probability < part_confidence([GOOD]).probability


def test_surfaces_that_do_not_overlap_are_not_matched_rightly() -> None:
    found = part_confidence([RefinedPartFit.of_nothing()], entire=False)
    assert found.probability == 0.0
    assert MISFIT in found.reasons
