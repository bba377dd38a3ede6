"""What of a shape another lacks."""

import time

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import Registration, register
from solver.registration.lacking import inside
from solver.shape import Shape
from synthetic import human
from tests.solver.shapes import plane_grid


def registered(source: Shape, target: Shape, here: IntArray, there: IntArray) -> Registration:
    """Begun at what corresponds, without a search for anything better."""
    found = register(source, target, [(here, there)], Control(deadline=time.monotonic()))
    assert found is not None
    return found


@pytest.fixture(scope="module")
def whole() -> Shape:
    body = human(resolution=2000)
    return Shape(triangle_mesh(body.vertices, body.faces))


@pytest.fixture(scope="module")
def kept(whole: Shape) -> IntArray:
    """Vertices of the whole without a leg."""
    side, height, _ = whole.mesh.vertices.T
    faces = whole.mesh.faces[~((side > 0.0) & (height < 0.0))[whole.mesh.faces].any(axis=1)]
    return np.unique(faces)


def test_a_leg_is_lacking_on_a_body_without_it(whole: Shape, kept: IntArray) -> None:
    """Its images are on the boundary, or on the other leg, which is not its partner."""
    faces = whole.mesh.faces[np.isin(whole.mesh.faces, kept).all(axis=1)]
    part = Shape(triangle_mesh(whole.mesh.vertices[kept], np.searchsorted(kept, faces)))
    missing = 1.0 - whole.spectrum().mass[kept].sum()
    rows = np.arange(0, len(kept), 100)
    forward = registered(whole, part, kept[rows], rows)
    back = registered(part, whole, rows, kept[rows])
    assert forward.share_lacking(Control(), of_source=True) == pytest.approx(missing, rel=0.4)
    assert back.share_lacking(Control(), of_source=False) == pytest.approx(missing, rel=0.4)
    assert forward.share_lacking(Control(), of_source=False) < 0.25 * missing
    assert back.share_lacking(Control(), of_source=True) < 0.25 * missing


def test_equal_sheets_lack_nothing() -> None:
    """Points of a boundary that go to the other's are not beyond it."""
    sheet = Shape(plane_grid(40, 40, 1.0))
    every = np.arange(0, sheet.n_vertices, 50)
    found = registered(sheet, sheet, every, every)
    for of_source in (False, True):
        assert found.share_lacking(Control(), of_source=of_source) == 0.0


def test_points_between_vertices_are_inside_but_on_edges_of_the_boundary() -> None:
    mesh = plane_grid(3, 3, 1.0)
    corners = mesh.faces[:1]
    bounding = mesh.on_boundary[corners[0]]
    assert bounding.sum() == 2
    on_edge, off_edge = 0.5 * bounding, (0.4 * bounding + 0.2 * ~bounding)
    faces = np.zeros(2, dtype=np.int64)
    found = inside(mesh, mesh.on_boundary, faces, np.stack([on_edge, off_edge]))
    np.testing.assert_array_equal(found, [False, True])
