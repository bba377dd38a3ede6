"""Refinement between vertices, on shapes whose correspondence is known."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.gmds import refine_by_gmds
from solver.matching import Match, MatchOptions, match
from solver.mesh import triangle_mesh
from solver.registration import Registration, register
from solver.shape import Shape
from synthetic import ASYMMETRIC_HUMAN, SyntheticShape, correspondence, human
from tests.solver import shapes

Pair = tuple[SyntheticShape, SyntheticShape]


@pytest.fixture(scope="module")
def figures() -> Pair:
    return (
        human("standing", ASYMMETRIC_HUMAN, resolution=1000, seed=1),
        human("walking", ASYMMETRIC_HUMAN, resolution=1000, seed=2),
    )


@pytest.fixture(scope="module")
def pair(figures: Pair) -> tuple[Shape, Shape]:
    one, other = (Shape(triangle_mesh(figure.vertices, figure.faces)) for figure in figures)
    return one, other


@pytest.fixture(scope="module")
def answer(pair: tuple[Shape, Shape]) -> Match:
    return match(*pair, MatchOptions(points=32, refine="gmds", proof="candidates"))


def registration(
    source: Shape, target: Shape, points: IntArray, partners: IntArray
) -> Registration:
    found = register(source, target, [(points, partners)], Control())
    assert found is not None
    return found


def apart(figures: Pair, source: IntArray, places: FloatArray) -> FloatArray:
    """Distance from each place to the truth in the rest pose, over √area."""
    area = Shape(triangle_mesh(figures[0].rest, figures[0].faces)).mesh.area
    off: FloatArray = np.linalg.norm(figures[0].rest[source] - places, axis=1) / np.sqrt(area)
    return off


def test_refined_points_lie_nearer_to_the_truth(figures: Pair, answer: Match) -> None:
    """By much: the matched vertices are at best those sampled, a covering radius apart."""
    refined = answer.refinement
    assert refined is not None
    before = apart(figures, answer.best.source, figures[1].rest[answer.best.target])
    places = refined.points.positions(figures[1].rest, figures[1].faces)
    after = apart(figures, refined.source, places)
    np.testing.assert_array_equal(refined.source, answer.best.source)
    assert after.mean() < 0.6 * before.mean()
    assert after.mean() < 0.03


def test_gmds_does_not_raise_the_stress(answer: Match) -> None:
    refined = answer.refinement
    assert refined is not None
    assert 0.0 <= refined.stress <= refined.initial_stress


def test_a_shape_is_refined_to_itself() -> None:
    shape = Shape(shapes.blob())
    points = shape.sampling("geodesic", 20).indices
    refined = refine_by_gmds(registration(shape, shape, points, points), points, Control())
    places = refined.points.positions(shape.surface.vertices, shape.surface.faces)
    np.testing.assert_allclose(places, shape.surface.vertices[points], atol=1e-9)
    assert refined.stress == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("scales", [(1.0, 1e3), (1e-8, 1e-8)], ids=["one", "both"])
def test_scale_changes_nothing(figures: Pair, scales: tuple[float, float]) -> None:
    """Neither of both shapes nor of one, normalised or not."""
    source, target = figures
    points = np.arange(0, len(source.vertices), 40)
    partners = correspondence(source, target)[points]
    results = []
    for (ours, theirs), normalise in (((1.0, 1.0), True), (scales, False)):
        one = Shape(triangle_mesh(ours * source.vertices, source.faces), normalise=normalise)
        other = Shape(triangle_mesh(theirs * target.vertices, target.faces), normalise=normalise)
        results.append(
            refine_by_gmds(registration(one, other, points, partners), points, Control())
        )
    first, second = results
    assert second.stress == pytest.approx(first.stress, rel=1e-6)
    np.testing.assert_allclose(
        first.points.positions(target.rest, target.faces),
        second.points.positions(target.rest, target.faces),
        atol=1e-5,
    )


def test_it_is_asked_for_by_name() -> None:
    with pytest.raises(OptionError, match="refine"):
        MatchOptions(refine="magic")
    assert MatchOptions(metric=("geodesic",), descriptor=("none",), refine="gmds").needs_spectrum
