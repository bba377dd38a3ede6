"""Winding of open surfaces: reversed in a file, it changes no answer."""

import numpy as np
import pytest

from solver.control import Control
from solver.matching import MatchOptions, match
from solver.matching.winding import wound_alike
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import Shape
from synthetic import human
from tests.solver import shapes
from tests.solver.matching.test_overlap import RESOLUTION, Cut, body

FLIPPED = "flipped all faces of the surface: it fits the other far better"


def inside_out(shape: Shape) -> Shape:
    mesh = shape.mesh
    return Shape(triangle_mesh(mesh.vertices, mesh.faces[:, ::-1]))


def sheet() -> TriangleMesh:
    """A bumpy disc without symmetries."""
    disc = shapes.disc(12)
    x, y, _ = disc.vertices.T
    height = 0.3 * np.exp(-8.0 * ((x - 0.4) ** 2 + y**2)) + 0.15 * np.exp(-9.0 * (y - 0.5) ** 2)
    return triangle_mesh(np.stack([x, 1.3 * y, height - 0.2 * x**2], axis=1), disc.faces)


@pytest.fixture(scope="module")
def halves() -> tuple[Cut, Shape]:
    """The left of a body, and the whole one in another pose."""
    rest = human("standing", resolution=RESOLUTION, seed=1).rest
    nothing = np.zeros(len(rest), dtype=np.bool_)
    left = body("walking", rest[:, 0] < 0.0, 1.0)
    return left, body("standing", nothing, 1.0)[0]


@pytest.mark.parametrize("swapped", [False, True])
def test_the_open_one_is_flipped(halves: tuple[Cut, Shape], swapped: bool) -> None:
    (left, _), whole = halves
    given = (whole, inside_out(left)) if swapped else (inside_out(left), whole)
    found = wound_alike(*given, Control())
    assert found[not swapped] is whole
    np.testing.assert_array_equal(found[swapped].mesh.faces, left.mesh.faces)
    assert FLIPPED in found[swapped].mesh.warnings[-1]


def test_what_fits_stays(halves: tuple[Cut, Shape]) -> None:
    (left, _), whole = halves
    assert wound_alike(left, whole, Control()) == (left, whole)


def test_flat_discs_stay() -> None:
    """Both sides of them are alike."""
    given = Shape(shapes.disc(12)), inside_out(Shape(shapes.disc(13)))
    assert wound_alike(*given, Control()) == given


def test_a_sheet_is_no_reflection_of_itself() -> None:
    source = Shape(sheet())
    target = inside_out(Shape(shapes.moved(sheet(), seed=3)))
    found = match(source, target, MatchOptions(points=16, dense=True))
    assert any(f"target: {FLIPPED}" in warning for warning in found.warnings)
    assert found.dense is not None
    np.testing.assert_array_equal(found.dense.target, found.dense.source)
    assert found.confidence is not None
    assert found.confidence.is_sure


def test_without_a_registration_the_winding_does_not_matter() -> None:
    given = Shape(sheet()), inside_out(Shape(sheet()))
    found = match(*given, MatchOptions(points=8, orientation=False))
    assert not any(FLIPPED in warning for warning in found.warnings)
