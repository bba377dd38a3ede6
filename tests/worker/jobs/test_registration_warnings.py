"""Warnings of registrations: which specimens are named, and which are not."""

from worker.jobs.registration_warnings import doubtful_specimens

NAMES = ["a", "b", "c"]


def test_matches_in_doubt_are_named_with_their_confidence() -> None:
    (said,) = doubtful_specimens(NAMES, [0.9, 0.314, None], [0.0, 0.0, 0.0], 0.0)
    assert "'b' (0.31)" in said
    assert "'a'" not in said
    assert "'c'" not in said
    assert doubtful_specimens(NAMES, [0.5, 1.0, None], [0.0, 0.0, 0.0], 0.0) == ()


def test_parts_have_more_boundary_than_the_template() -> None:
    boundaries = [0.2, 2.5, 3.1]
    (said,) = doubtful_specimens(NAMES, [0.9] * 3, boundaries, 0.0)
    assert "'b' (2.5 √area), 'c' (3.1 √area)" in said
    assert "'a'" not in said
    (said,) = doubtful_specimens(NAMES, [0.9] * 3, boundaries, 2.0)
    assert "'c'" in said
    assert "'b'" not in said
