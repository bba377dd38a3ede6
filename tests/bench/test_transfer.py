"""Figures of carried values on surfaces whose answer is known."""

import numpy as np
import pytest

from bench.collection import KnownShape
from bench.transfer import area_share, judged, segments_of
from solver.registration import DenseCorrespondence
from solver.shape import Shape
from tests.solver import shapes

MESH = shapes.blob(2)
COUNT = MESH.n_vertices
KNOWN = KnownShape("one", "one", Shape(MESH), np.arange(COUNT), None)


def identity() -> DenseCorrespondence:
    every = np.arange(COUNT)
    corners, weights = np.repeat(every[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (COUNT, 1))
    inverse = DenseCorrespondence(every, every, corners, weights)
    return DenseCorrespondence(every, every, corners, weights, 0, inverse)


def test_the_identity_loses_nothing() -> None:
    found = judged(KNOWN, KNOWN, identity())
    assert (found.forwards, found.backwards, found.uncovered) == (1.0, 1.0, 0.0)
    assert found.loss < 1e-12
    assert (found.faces, found.faces_back) == (1.0, 1.0)


def test_segments_are_cells_of_the_surface() -> None:
    labels = segments_of(KNOWN, 5)
    assert set(labels) == set(range(5))


def test_the_share_is_that_of_the_area() -> None:
    labels = segments_of(KNOWN, 4)
    carried = np.where(labels == 2, 0, labels)
    mass = KNOWN.shape.spectrum().mass
    expected = 1.0 - mass[labels == 2].sum() / mass.sum()
    assert area_share(KNOWN, KNOWN, labels, carried) == pytest.approx(expected)
    few = KnownShape("one", "one", KNOWN.shape, np.array([3, -1, 7]), None)
    wrong = np.where(np.arange(COUNT) == 7, labels, 99)
    share = mass[7] / (mass[3] + mass[7])
    assert area_share(few, few, labels, wrong) == pytest.approx(share)
