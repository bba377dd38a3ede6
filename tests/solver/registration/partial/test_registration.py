"""Parts cut out of known surfaces, moved and scaled."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.errors import Cancelled
from solver.functional_maps import FunctionalMap
from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration import reduction
from solver.registration.alignment import Alignment
from solver.registration.confidence import RIVAL
from solver.registration.partial import PartMap, register_part
from solver.registration.partial.cover import covered_by_part, covered_by_whole, largest_patch
from solver.registration.surface import smooth_surface
from solver.registration.surface_map import SurfaceMap
from solver.shape import Shape
from synthetic import human, submesh
from tests.solver.shapes import icosphere, plane_grid

SCALE = 3.0


def cut(mesh: TriangleMesh, kept: BoolArray, scale: float = SCALE) -> tuple[TriangleMesh, IntArray]:
    """The triangles all of whose corners are kept, turned, moved and scaled; and their vertices."""
    vertices, part = submesh(mesh, np.all(kept[mesh.faces], axis=1))
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    moved = scale * (part.vertices @ turn + [3.0, -1.0, 2.0])
    return triangle_mesh(moved, part.faces), vertices


@pytest.fixture(scope="module")
def whole() -> Shape:
    body = human("walking", resolution=700)
    return Shape(triangle_mesh(body.vertices, body.faces))


@pytest.fixture(scope="module")
def without_a_leg(whole: Shape) -> tuple[Shape, IntArray]:
    """What is above the knee of one leg, and all of the other one."""
    positions = whole.mesh.vertices
    height, side = positions[:, 1] - positions[:, 1].min(), positions[:, 0]
    leg = (height < 0.4 * np.ptp(positions[:, 1])) & (side > np.median(side))
    part, vertices = cut(whole.mesh, ~leg)
    return Shape(part), vertices


@pytest.fixture(scope="module")
def found(whole: Shape, without_a_leg: tuple[Shape, IntArray]) -> PartMap:
    found = register_part(whole, without_a_leg[0], Control())
    assert found is not None
    return found


def scale_of(found: PartMap) -> float:
    """√area of the whole over √area of the part, which is the target."""
    return float(found.target.unit / found.target.shape.mesh.area**0.5)


def places(shape: Shape, faces: IntArray, barycentric: FloatArray) -> FloatArray:
    found: FloatArray = np.einsum(
        "vc,vcd->vd", barycentric, shape.mesh.vertices[shape.mesh.faces[faces]]
    )
    return found


def test_the_scale_of_a_part_is_found(
    whole: Shape, without_a_leg: tuple[Shape, IntArray], found: PartMap
) -> None:
    part, _ = without_a_leg
    expected = SCALE * np.sqrt(whole.mesh.area / part.mesh.area)
    assert scale_of(found) == pytest.approx(expected, rel=0.02)


def test_the_answer_in_exchanged_roles_is_a_rival_if_it_differs(found: PartMap) -> None:
    turned = replace(found, bent=1)
    assert found.among(turned, Control()) is found
    vertices, faces, barycentric = found.source.images
    moved = replace(found.source, images=(vertices[::-1], faces, barycentric))
    other = replace(turned, sides=(moved, found.target))
    doubted = found.among(other, Control())
    assert doubted.sides is found.sides
    assert doubted.confidence.probability < 0.5
    assert RIVAL in doubted.confidence.reasons


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_answers_in_exchanged_roles_are_compared_in_any_unit(found: PartMap, unit: float) -> None:
    sides = [
        replace(one, shape=Shape(one.shape.mesh.scaled(unit)))
        for one in (found.source, found.target)
    ]
    scaled = replace(found, sides=(sides[0], sides[1]))
    mesh = scaled.target.shape.mesh
    vertices, faces, barycentric = found.source.images
    for away, differs in ((0.05, False), (0.3, True)):
        shifted = mesh.vertices[vertices] + away * np.sqrt(mesh.area) * np.array([0.0, 1.0, 0.0])
        there = np.asarray(KDTree(mesh.vertices).query(shifted)[1])
        moved = replace(scaled.source, images=(there, faces, barycentric))
        other = replace(scaled, bent=1, sides=(moved, scaled.target))
        assert (scaled.among(other, Control()) is not scaled) == differs


def test_every_vertex_of_a_part_goes_back_where_it_was(
    whole: Shape, without_a_leg: tuple[Shape, IntArray], found: PartMap
) -> None:
    _, vertices = without_a_leg
    errors = np.linalg.norm(
        places(whole, *found.target.images[1:]) - whole.mesh.vertices[vertices], axis=1
    )
    assert errors.mean() < 0.01 * np.sqrt(whole.mesh.area)


def test_a_part_of_many_vertices_is_searched_on_fewer(
    whole: Shape, without_a_leg: tuple[Shape, IntArray], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reduction, "MANY_VERTICES", 300)
    part, vertices = without_a_leg
    found = register_part(whole, part, Control(), scale=1.1)
    assert found is not None
    assert len(found.source.covered) == whole.n_vertices
    assert scale_of(found) == pytest.approx(1.1)
    errors = np.linalg.norm(
        places(whole, *found.target.images[1:]) - whole.mesh.vertices[vertices], axis=1
    )
    assert errors.mean() < 0.02 * np.sqrt(whole.mesh.area)


def test_vertices_that_the_part_lacks_have_no_partner(
    whole: Shape, without_a_leg: tuple[Shape, IntArray], found: PartMap
) -> None:
    _, vertices = without_a_leg
    there = np.isin(np.arange(whole.n_vertices), vertices)
    mass = whole.spectrum().mass
    assert mass[found.source.covered != there].sum() < 0.05
    assert found.source.share == pytest.approx(mass[there].sum(), abs=0.05)


def test_maps_name_the_vertices_of_the_files(whole: Shape, found: PartMap) -> None:
    """Of the whole, those that have a partner."""
    dense = found.dense()
    assert dense.inverse is not None
    np.testing.assert_array_equal(dense.source, np.flatnonzero(found.source.covered))
    np.testing.assert_array_equal(dense.inverse.source, np.arange(found.target.shape.n_vertices))


def test_the_registration_is_in_the_order_of_source_and_target(
    whole: Shape, without_a_leg: tuple[Shape, IntArray], found: PartMap
) -> None:
    turned = register_part(without_a_leg[0], whole, Control(), source_is_part=True)
    assert turned is not None
    assert (turned.bent, found.bent) == (1, 0)
    for one, other in zip(turned.sides[::-1], found.sides, strict=True):
        assert one.shape is other.shape
        assert one.unit == other.unit
        np.testing.assert_array_equal(one.covered, other.covered)
        np.testing.assert_array_equal(one.images[0], other.images[0])


def test_a_given_scale_is_kept(whole: Shape, without_a_leg: tuple[Shape, IntArray]) -> None:
    part, _ = without_a_leg
    # Without time for a search: every candidate has this scale.
    found = register_part(whole, part, Control(deadline=time.monotonic()), scale=1.1)
    assert found is not None
    assert scale_of(found) == pytest.approx(1.1)


def test_units_of_length_do_not_matter(
    whole: Shape, without_a_leg: tuple[Shape, IntArray], found: PartMap
) -> None:
    same, part = (Shape(one.mesh, normalise=False) for one in (whole, without_a_leg[0]))
    again = register_part(same, part, Control())
    assert again is not None
    assert scale_of(again) == pytest.approx(scale_of(found), rel=1e-6)
    np.testing.assert_array_equal(again.source.covered, found.source.covered)


def test_every_point_of_a_part_has_a_partner(found: PartMap) -> None:
    assert found.target.covered.all()
    assert found.target.share == 1.0


@pytest.mark.parametrize("flipped", [False, True])
def test_vertices_of_coarse_meshes_have_partners(flipped: bool) -> None:
    """A ball of 42 vertices covers one of 2,562, whose edges are a tenth as long; and back."""
    balls = [smooth_surface(Shape(icosphere(level))) for level in (4, 1)]
    whole, part = balls[::-1] if flipped else balls
    rest = Alignment(whole.coefficients[:1], FunctionalMap(np.eye(1)), np.eye(3))
    known = SurfaceMap.of(whole, part, rest, reflected=False)
    known = known.moved(known.positions)
    images, back = known.images(), known.inverse()
    assert covered_by_part(known, images, back[0], 1.0).all()
    assert covered_by_whole(known, images, back, 1.0).all()


def test_a_square_that_fits_in_four_ways_is_doubted() -> None:
    square = Shape(plane_grid(15, 15, 1.0))
    found = register_part(square, square, Control())
    assert found is not None
    assert found.confidence.probability <= 0.1
    assert RIVAL in found.confidence.reasons


def test_the_largest_patch_is_kept(whole: Shape) -> None:
    """Of both feet and a torso; a gap of two edges does not part a patch."""
    surface = smooth_surface(whole)
    height = whole.mesh.vertices[:, 1]
    level = (height - height.min()) / np.ptp(height)
    torso = level > 0.5
    np.testing.assert_array_equal(largest_patch(surface, torso | (level < 0.1)), torso)
    holed = torso.copy()
    holed[np.flatnonzero(torso)[::40]] = False
    np.testing.assert_array_equal(largest_patch(surface, holed), holed)
    assert not largest_patch(surface, np.zeros(whole.n_vertices, dtype=np.bool_)).any()


def test_a_registration_is_cancelled(whole: Shape, without_a_leg: tuple[Shape, IntArray]) -> None:
    with pytest.raises(Cancelled):
        register_part(whole, without_a_leg[0], Control(is_cancelled=lambda: True))
