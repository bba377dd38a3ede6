"""Extremities: the ends of limbs, and their matchings in the order of distortion."""

import numpy as np
import pytest

from solver.mesh import triangle_mesh
from solver.registration.extremities import matched_extremities
from solver.registration.surface import Samples, SmoothSurface, commute_times, smooth_surface
from solver.shape import Shape
from synthetic import SyntheticShape, human


@pytest.fixture(scope="module")
def figure() -> SyntheticShape:
    return human("walking", resolution=1000, seed=2)


@pytest.fixture(scope="module")
def person(figure: SyntheticShape) -> SmoothSurface:
    return smooth_surface(Shape(triangle_mesh(figure.vertices, figure.faces)))


@pytest.fixture(scope="module")
def samples(person: SmoothSurface) -> Samples:
    return person.samples.first(200)


def test_those_of_a_person_are_head_hands_and_feet(
    figure: SyntheticShape, samples: Samples
) -> None:
    ours, _ = matched_extremities(samples, samples)[0]
    rest = figure.rest
    low = np.flatnonzero(rest[:, 1] < np.median(rest[:, 1]))
    ends = [rest[:, 1].argmax(), rest[:, 0].argmax(), rest[:, 0].argmin()]
    ends += [low[(side * rest[low, 0] - rest[low, 1]).argmax()] for side in (1.0, -1.0)]
    apart = np.linalg.norm(rest[ours][:, None] - rest[ends], axis=2)
    assert sorted(apart.argmin(axis=1)) == [0, 1, 2, 3, 4]
    assert apart.min(axis=1).max() < 0.15 * np.ptp(rest[:, 1])


def test_a_surface_is_matched_to_itself_first(samples: Samples) -> None:
    ours, theirs = matched_extremities(samples, samples)[0]
    np.testing.assert_array_equal(ours, theirs)


def test_matchings_differ_and_come_in_the_order_of_distortion(
    samples: Samples, surface: SmoothSurface
) -> None:
    other = surface.samples.first(300)
    found = matched_extremities(samples, other)
    assert len({tuple(theirs.tolist()) for _, theirs in found}) == len(found) == 400
    distortions = []
    for ours, theirs in found:
        assert len(set(theirs.tolist())) == len(ours) == 5
        here, there = (
            commute_times(one, np.arange(len(one)))[
                np.ix_(*2 * [[one.vertices.tolist().index(v) for v in vertices]])
            ]
            for one, vertices in ((samples, ours), (other, theirs))
        )
        distortions.append(np.abs(here - there).sum())
    assert (np.diff(distortions) > -1e-4).all()


def test_few_samples_have_few_extremities(samples: Samples, surface: SmoothSurface) -> None:
    for here, there in ((samples.first(4), surface.samples.first(6)), (samples, samples.first(4))):
        found = matched_extremities(here, there)
        assert found
        assert all(len(ours) == len(theirs) == 4 for ours, theirs in found)
