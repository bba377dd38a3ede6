"""Refined parts: what is torn off returns."""

import time
from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration.partial.comparison import refine_candidates
from solver.registration.partial.partiality import OF_PART
from solver.registration.partial.refinement import RefinedPart
from solver.registration.partial.search import search_part
from solver.registration.partial.task import PartTask
from solver.shape import Shape
from synthetic import human

Feet = tuple[BoolArray, BoolArray]


@pytest.fixture(scope="module")
def whole() -> Shape:
    body = human(resolution=1500)
    return Shape(triangle_mesh(body.vertices, body.faces))


@pytest.fixture(scope="module")
def kept(whole: Shape) -> IntArray:
    """Vertices of the whole without an arm."""
    side = whole.mesh.vertices[:, 0] / np.ptp(whole.mesh.vertices[:, 1])
    return np.flatnonzero(side < 0.12)


@pytest.fixture(scope="module")
def right(whole: Shape, kept: IntArray) -> RefinedPart:
    faces = whole.mesh.faces[np.isin(whole.mesh.faces, kept).all(axis=1)]
    assert (np.unique(faces) == kept).all()
    part = Shape(triangle_mesh(whole.mesh.vertices[kept], np.searchsorted(kept, faces)))
    scale = float(np.sqrt(whole.mesh.area / part.mesh.area))
    task = PartTask((whole, part), OF_PART, scale)
    best, *_ = refine_candidates(task, search_part(task, Control()), Control())
    return best.part


@pytest.fixture(scope="module")
def feet(whole: Shape) -> Feet:
    """Vertices of the whole on either side."""
    side, height, _ = whole.mesh.vertices.T
    foot = height < height.min() + 0.13 * np.ptp(height)
    return foot & (side > 0.0), foot & (side < 0.0)


def apart(found: RefinedPart, kept: IntArray) -> FloatArray:
    """How far from where it was each vertex of the part goes, in √area of the whole."""
    whole = found.displaced.source.mesh.vertices
    errors: FloatArray = np.linalg.norm(whole[found.back[0]] - whole[kept], axis=1)
    return errors


def test_what_is_not_torn_stays(right: RefinedPart, kept: IntArray) -> None:
    assert apart(right, kept).max() < 0.1
    assert right.mended(Control()) is right


def test_feet_that_are_exchanged_are_torn_off_and_return(
    right: RefinedPart, kept: IntArray, feet: Feet
) -> None:
    """As rigidly as possible alone, they stay on the wrong legs."""
    known = right.displaced
    between = known.positions[feet[0]].mean(axis=0) - known.positions[feet[1]].mean(axis=0)
    displaced = known.moved(known.positions - np.subtract(*feet, dtype=float)[:, None] * between)
    exchanged = replace(
        right, displaced=displaced, images=displaced.images(), back=displaced.inverse()
    )
    held = exchanged.again(Control())
    on_feet = np.logical_or(*feet)[kept]
    assert (apart(held, kept)[on_feet] > 0.1).mean() > 0.5
    assert apart(held.mended(Control()), kept).max() < 0.1
    assert held.mended(Control(deadline=time.monotonic())) is held
