"""Bodies of other proportions: still closed surfaces, and points are transferred between them."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import triangle_mesh
from synthetic import ALIEN, CLASSES, HumanProportions, human, human_figure, transferred
from synthetic.implicit import body

_STANDARD = human_figure(HumanProportions())
_BODIES = {
    "alien": ALIEN,
    "heavy": HumanProportions(head=1.3, arm=0.8, leg=0.8, girth=1.25, limbs=1.2),
}


def standard_skin() -> FloatArray:
    return human("rest", resolution=800).rest


@pytest.mark.parametrize("name", _BODIES)
def test_unusual_bodies_are_closed_surfaces_of_genus_0(name: str) -> None:
    shape = human("standing", _BODIES[name], resolution=800)
    mesh = triangle_mesh(shape.vertices, shape.faces)
    assert mesh.closed
    assert mesh.components == 1
    assert mesh.n_vertices - len(mesh.edges) + mesh.n_faces == 2


def test_a_body_is_carried_to_itself() -> None:
    points = standard_skin()
    np.testing.assert_allclose(transferred(points, _STANDARD, _STANDARD), points, atol=1e-6)


@pytest.mark.parametrize("name", _BODIES)
def test_points_are_carried_onto_the_other_body_and_back(name: str) -> None:
    points, other = standard_skin(), human_figure(_BODIES[name])
    images = transferred(points, _STANDARD, other)
    heights = body(other.cones(), other.blend, images).value
    np.testing.assert_allclose(heights, 0.0, atol=1e-4)
    back = np.linalg.norm(transferred(images, other, _STANDARD) - points, axis=1)
    assert back.mean() < 0.005
    mirrored = np.array([-1.0, 1.0, 1.0])
    np.testing.assert_allclose(
        transferred(points * mirrored, _STANDARD, other), images * mirrored, atol=1e-6
    )


def test_landmarks_are_carried_to_landmarks() -> None:
    other = human_figure(ALIEN)
    for (name, here), (same, there) in zip(_STANDARD.landmarks, other.landmarks, strict=True):
        assert name == same
        image = transferred(np.array([here]), _STANDARD, other)[0]
        assert np.linalg.norm(image - there) < 0.06, name


def test_figures_of_different_kinds_are_refused() -> None:
    with pytest.raises(ValueError, match="different kinds"):
        transferred(standard_skin(), _STANDARD, CLASSES["cat"].figure)
