"""Generated pairs are the same in every run, and their truth is right."""

import numpy as np
import pytest

from bench.varied_pairs import AS_IT_IS, CONDITIONS, DIFFERENT, KINDS, varied_pair


def test_a_pair_is_the_same_for_the_same_numbers() -> None:
    one, again, other = varied_pair(0), varied_pair(0), varied_pair(0, seed=1)
    for first, second in ((one.source, again.source), (one.target, again.target)):
        np.testing.assert_array_equal(first.shape.mesh.vertices, second.shape.mesh.vertices)
        np.testing.assert_array_equal(first.truth, second.truth)
    assert one.condition == again.condition
    assert one.source.shape.n_vertices != other.source.shape.n_vertices


@pytest.mark.parametrize("condition", [AS_IT_IS, "noise", "holes", "glued", "coarse", "fine"])
def test_partners_are_as_far_apart_on_both_bodies(condition: str) -> None:
    # Two poses of one individual: geodesic distances hardly change.
    pair = varied_pair(0, condition=condition)
    assert pair.condition == condition
    source, target = pair.source, pair.target
    assert source.truth is not None
    assert target.truth is not None
    assert target.symmetric_truth is not None
    assert len(source.truth) == len(target.truth) == len(target.symmetric_truth)
    places = np.random.default_rng(0).choice(len(source.truth), 30, replace=False)
    here, there = (
        one.shape.metric("geodesic").between(truth[places])
        for one, truth in ((source, source.truth), (target, target.truth))
    )
    assert np.median(np.abs(here - there)) < 0.06
    assert here.max() > 1.0


def test_pairs_of_different_classes_have_no_truth() -> None:
    pair = varied_pair(list(KINDS).index(DIFFERENT), condition=AS_IT_IS)
    assert pair.source.truth is None
    assert pair.target.truth is None


def test_every_condition_is_tested() -> None:
    assert set(CONDITIONS) == {AS_IT_IS, "noise", "holes", "glued", "coarse", "fine"}
