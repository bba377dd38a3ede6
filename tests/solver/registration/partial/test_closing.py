"""Candidates of a part whose holes are closed."""

import numpy as np
import pytest

from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration.candidates import NO_LANDMARKS
from solver.registration.partial.choice import PartTask
from solver.registration.partial.closing import starts_with_holes_closed
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from synthetic import human


@pytest.fixture(scope="module")
def whole() -> Shape:
    body = human("walking", resolution=1000, seed=1)
    return Shape(triangle_mesh(body.vertices, body.faces))


def task(whole: Shape, part: Shape) -> PartTask:
    surfaces = smooth_surface(whole), smooth_surface(part)
    return PartTask(*surfaces, entire=True, rescaled=True, landmarks=NO_LANDMARKS)


def test_a_body_without_a_hand_is_laid_onto_the_whole(whole: Shape) -> None:
    side = whole.mesh.vertices[:, 0]
    faces = whole.mesh.faces[(side[whole.mesh.faces] < np.quantile(side, 0.97)).all(axis=1)]
    vertices = np.unique(faces)
    # In other units.
    mesh = triangle_mesh(3.0 * whole.mesh.vertices[vertices], np.searchsorted(vertices, faces))
    part = Shape(mesh)
    surfaces = task(whole, part)
    starts = list(starts_with_holes_closed(surfaces, part, None, Control()))
    length = np.sqrt(whole.mesh.area / (mesh.area / 9.0))
    away = []
    for alignment, scale in starts:
        assert scale == pytest.approx(length, rel=0.02)
        functions = surfaces.whole.spectrum.eigenfunctions[vertices, : alignment.size]
        there = functions @ alignment.coefficients
        apart = np.linalg.norm(there - surfaces.part.mesh.vertices, axis=1)
        away.append(float(apart.mean()))
    # Twelve eigenfunctions describe this body up to 0.054.
    assert min(away) < 0.1


def test_a_scale_that_is_known_is_kept(whole: Shape) -> None:
    faces = whole.mesh.faces[10:]
    part = Shape(triangle_mesh(whole.mesh.vertices, faces))
    starts = starts_with_holes_closed(task(whole, part), part, 1.25, Control())
    assert {scale for _, scale in starts} == {1.25}


def test_nothing_begins_at_a_part_without_holes(whole: Shape) -> None:
    assert list(starts_with_holes_closed(task(whole, whole), whole, None, Control())) == []
