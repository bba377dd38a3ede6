"""GMDS as a method of its own: samples embedded into other shapes."""

import numpy as np
import pytest

from solver.control import Control
from solver.errors import OptionError
from solver.gmds import embed
from solver.mesh import triangle_mesh
from solver.shape import Shape
from tests.solver import shapes


@pytest.fixture(scope="module")
def shape() -> Shape:
    return Shape(shapes.blob())


def test_a_shape_is_embedded_into_its_own_copy(shape: Shape) -> None:
    """Renumbered and turned: the samples' images are themselves, and no distance is distorted."""
    mesh = shape.mesh
    numbering = np.random.default_rng(2).permutation(mesh.n_vertices)
    turn, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    vertices = np.empty_like(mesh.vertices)
    vertices[numbering] = mesh.vertices @ turn
    copy = Shape(triangle_mesh(vertices, numbering[mesh.faces]))
    found = embed(shape, copy, 8)
    assert found.distortion < 0.01
    places = found.solution.answer.positions(copy.surface.vertices, copy.surface.faces)
    truth = copy.surface.vertices[numbering[found.vertices]]
    assert np.linalg.norm(places - truth, axis=1).max() < 0.05


def test_the_stress_is_that_of_the_points_and_no_more_than_where_they_began(shape: Shape) -> None:
    other = Shape(shapes.torus())
    found = embed(shape, other, 6)
    assert len(found.vertices) == len(found.solution.answer) == 6
    assert found.solution.value <= found.solution.history[0]
    assert found.distortion == pytest.approx(np.sqrt(2.0 * found.solution.value / 30))


def test_past_the_deadline_many_samples_have_distinct_images(shape: Shape) -> None:
    other = Shape(shapes.torus())
    found = embed(shape, other, 60, control=Control(deadline=0.0))
    assert len(np.unique(found.solution.answer.nearest_vertices(other.surface))) == 60


def test_more_samples_than_vertices_are_refused(shape: Shape) -> None:
    with pytest.raises(OptionError, match="vertices"):
        embed(Shape(shapes.icosphere(0)), shape, 13)
    with pytest.raises(OptionError, match="vertices"):
        embed(shape, Shape(shapes.icosphere(0)), 13)
