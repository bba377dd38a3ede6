"""Changes of the input carry the truth along."""

import numpy as np
import pytest

from bench.collection import KnownShape
from bench.robust import CHANGES, RobustAnswer, Robustness, changed
from bench.symmetry import mirrored_vertices
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import human


@pytest.fixture(scope="module")
def body() -> KnownShape:
    figure = human("walking", resolution=600)
    every = np.arange(600)
    mirrored = mirrored_vertices(figure.rest)
    shape = Shape(triangle_mesh(figure.vertices, figure.faces))
    return KnownShape("human", "human", shape, every, mirrored)


@pytest.mark.parametrize("name", [name for name in CHANGES if name != "reflected"])
def test_points_stay_at_their_places(body: KnownShape, name: str) -> None:
    after = changed(body, CHANGES[name])
    assert body.truth is not None
    assert after.truth is not None
    metrics = [one.shape.metric("geodesic") for one in (body, after)]
    places = np.random.default_rng(0).choice(len(body.truth), 20, replace=False)
    here, there = (
        metric.between(truth[places])
        for metric, truth in zip(metrics, (body.truth, after.truth), strict=True)
    )
    assert np.abs(here - there).mean() < 0.05
    assert np.abs(here - there).max() < 0.25


def test_a_reflection_exchanges_the_truths(body: KnownShape) -> None:
    after = changed(body, CHANGES["reflected"])
    np.testing.assert_array_equal(after.truth, body.symmetric_truth)
    np.testing.assert_array_equal(after.symmetric_truth, body.truth)
    volume = [
        np.linalg.det(one.shape.mesh.vertices[one.shape.mesh.faces]).sum() for one in (body, after)
    ]
    assert volume[0] == pytest.approx(volume[1])


def test_figures_compare_answers_with_those_before() -> None:
    before = (RobustAnswer(0.02, None, 0.9, ("old",)), RobustAnswer(0.04, 0.3, 0.8, ()))
    after = (RobustAnswer(0.05, None, 0.7, ("old",)), RobustAnswer(0.2, 0.3, 0.1, ("new",)))
    figures = Robustness(before, after).figures()
    assert figures == pytest.approx(
        {
            "pairs": 2,
            "before": 0.03,
            "after": 0.125,
            "greatest_change": 0.16,
            "wrong_before": 0.0,
            "wrong_after": 0.5,
            "probability_before": 0.85,
            "probability_after": 0.4,
            "told": 0.5,
        }
    )
