"""Warnings of registrations: which specimens are named, and which are not."""

import numpy as np
import pytest

from tests.solver import shapes
from worker.jobs.registration_warnings import doubtful_specimens, relative_boundary

NAMES = ["a", "b", "c"]


def test_a_hemisphere_has_the_boundary_of_its_circle() -> None:
    cap = shapes.spherical_cap(np.pi / 2)
    assert relative_boundary(cap) == pytest.approx(np.sqrt(2 * np.pi), rel=0.01)
    assert relative_boundary(shapes.icosphere()) == 0.0


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
