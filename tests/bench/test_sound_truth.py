"""Truth that is torn between neighbours."""

import numpy as np

from bench.collection import KnownShape
from bench.sound_truth import with_sound_truth
from solver.shape import Shape
from tests.solver.shapes import icosphere


def test_points_whose_partners_lie_elsewhere_are_left_out() -> None:
    shape = Shape(icosphere(3))
    places = shape.mesh.vertices
    opposite = np.linalg.norm(places[:, None] + places, axis=2).argmin(axis=1)
    every = np.flatnonzero(np.linalg.norm(places - places[0], axis=1) > 0.3)
    cap = np.isin(opposite[every], np.setdiff1d(np.arange(len(places)), every))
    torn = np.where(cap, opposite[every], every)
    assert cap.sum() > 10
    known = KnownShape("one", "one", shape, every, every)
    for source, target in (
        (known, KnownShape("other", "one", shape, torn, None)),
        (KnownShape("other", "one", shape, torn, None), known),
    ):
        ours, theirs = with_sound_truth(source, target)
        assert ours.truth is not None
        assert theirs.truth is not None
        np.testing.assert_array_equal(ours.truth, every[~cap])
        np.testing.assert_array_equal(theirs.truth, every[~cap])
    assert known.symmetric_truth is not None
    kept = with_sound_truth(known, known)[0]
    np.testing.assert_array_equal(kept.truth, every)


def test_points_that_a_shape_lacks_are_left_out() -> None:
    shape = Shape(icosphere(3))
    every = np.arange(shape.mesh.n_vertices)
    lacking = np.where(every < 5, -1, every)
    whole = KnownShape("whole", "one", shape, every, every)
    part = KnownShape("part", "one", shape, lacking, None)
    for pair in ((whole, part), (part, whole)):
        for found in with_sound_truth(*pair):
            assert found.truth is not None
            np.testing.assert_array_equal(found.truth, every[5:])
