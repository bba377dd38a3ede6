"""What texture adds to a match: which of two mirror images is the truth."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.matching import Correspondence, MatchOptions, match
from solver.mesh import read_mesh
from solver.shape import Shape
from solver.shape.choices import Photometric
from tests.solver.mesh.textures.textured_figures import TexturedPerson, textured_person

MIRROR = np.array([-1.0, 1.0, 1.0])
OPTIONS = MatchOptions(
    points=7,
    metric=("commute_time",),
    descriptor=(Photometric(radius=0.1),),
    beta=1.0,
    first_order_weight=1.0,
    orientation=False,  # colours alone decide, against the surface where they are mirrored
)


@pytest.fixture(scope="module")
def people() -> tuple[TexturedPerson, TexturedPerson]:
    return textured_person("standing", 0), textured_person("walking", 1)


def apart(
    found: Correspondence, source: TexturedPerson, target: TexturedPerson, turn: FloatArray
) -> FloatArray:
    """Distances in metres, on the figure at rest, of matched points from where they belong."""
    here = source.rest[found.source % len(source.rest)] * turn
    distances: FloatArray = np.linalg.norm(here - target.rest[found.target], axis=1)
    return distances


def test_texture_tells_left_from_right_and_a_mirrored_texture_right_from_left(
    people: tuple[TexturedPerson, TexturedPerson],
) -> None:
    standing, walking = people
    source = Shape(read_mesh(standing.glb(), "glb"))
    target = Shape(read_mesh(walking.zip(), "zip"))
    found = match(source, target, OPTIONS).best
    assert apart(found, standing, walking, np.ones(3)).max() < 0.3
    assert apart(found, standing, walking, MIRROR).max() > 1.0

    swapped = replace(walking, rest=walking.rest * MIRROR, faces=walking.faces[:, ::-1])
    mesh = read_mesh(swapped.zip(), "zip")
    found = match(source, Shape(mesh), OPTIONS).best
    assert apart(found, standing, walking, MIRROR).max() < 0.3
    assert apart(found, standing, walking, np.ones(3)).max() > 1.0


def test_both_files_of_one_person_have_the_same_colors(
    people: tuple[TexturedPerson, TexturedPerson],
) -> None:
    person = people[0]
    glb, obj = read_mesh(person.glb(), "glb"), read_mesh(person.zip(), "zip")
    assert glb.closed
    assert obj.closed
    assert glb.colors is not None
    assert obj.colors is not None
    number = glb.vertex_ids % len(person.vertices)
    np.testing.assert_allclose(glb.colors, obj.colors[number], atol=1e-4)
    np.testing.assert_array_equal(np.sort(obj.vertex_ids), np.arange(len(person.vertices)))
