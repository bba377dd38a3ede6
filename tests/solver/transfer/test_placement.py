"""Landmarks in space on their surface, beside it, far from it, and in another coordinate system."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.errors import MisplacedLandmarks
from solver.mesh import TriangleMesh
from solver.transfer import place_landmarks
from tests.solver import shapes
from tests.solver.transfer.maps import MESH

SIZE = float(np.sqrt(MESH.area))
LABELS = tuple(f"p{place}" for place in range(6))


def moved(offset: tuple[float, float, float]) -> TriangleMesh:
    return MESH.with_same_faces(vertices=MESH.vertices + offset)


def samples(mesh: TriangleMesh, seed: int = 5) -> FloatArray:
    """Random points of the surface, (6, 3)."""
    random = np.random.default_rng(seed)
    corners = mesh.vertices[mesh.faces[random.integers(0, mesh.n_faces, 6)]]
    found: FloatArray = np.einsum("nc,ncd->nd", random.dirichlet(np.ones(3), size=6), corners)
    return found


PLACES = samples(MESH)


def test_points_of_the_surface_stand_for_themselves() -> None:
    given = PLACES.copy()
    given[2] = np.nan
    found = place_landmarks(LABELS, given, MESH)
    np.testing.assert_allclose(found.points.positions(MESH), given, atol=1e-12)
    expected = np.where(np.arange(6) == 2, np.nan, 0.0)
    np.testing.assert_allclose(found.from_surface, expected, atol=1e-12)
    assert found.remarks == ()


def test_vertices_have_the_numbers_of_their_file() -> None:
    copy, truth = shapes.permuted(MESH, seed=5)
    found = place_landmarks(LABELS[:2], MESH.vertices[[3, 99]], copy)
    main = found.points.corners[np.arange(2), found.points.barycentric.argmax(axis=1)]
    np.testing.assert_array_equal(main, truth[[3, 99]])


def test_no_point_of_the_surface_is_nearer() -> None:
    outwards = PLACES * 1.03
    found = place_landmarks(LABELS, outwards, MESH)
    nearest = np.linalg.norm(found.points.positions(MESH) - outwards, axis=1)
    np.testing.assert_allclose(found.from_surface, nearest / SIZE)
    assert (nearest <= np.linalg.norm(PLACES - outwards, axis=1)).all()
    assert nearest.min() > 0.0


def test_landmarks_far_from_the_surface_are_named_and_left_out() -> None:
    far = np.concatenate([PLACES[:3], PLACES[3:] * 20.0])
    found = place_landmarks((*LABELS[:5], None), far, MESH)
    assert np.isnan(found.from_surface).tolist() == 3 * [False] + 3 * [True]
    assert np.isnan(found.points.positions(MESH)).any(axis=1).tolist() == 3 * [False] + 3 * [True]
    (text,) = found.remarks
    assert text.startswith("3 of 6 landmarks are far from the surface, ")
    assert text.endswith("; they are left out")
    assert all(f"{name} by " in text for name in ("'p3'", "'p4'", "number 5"))
    (text,) = place_landmarks(LABELS, np.vstack([PLACES[:5], far[5:]]), MESH).remarks
    assert text.startswith("1 of 6 landmarks is far from the surface, 'p5' by ")
    assert text.endswith("; it is left out")


def test_landmarks_that_are_all_far_are_refused() -> None:
    with pytest.raises(MisplacedLandmarks, match=r"6 of 6 landmarks are far .*: check the unit"):
        place_landmarks(LABELS, PLACES * 2.0, MESH)


def test_missing_landmarks_are_no_error() -> None:
    found = place_landmarks(LABELS, np.full((6, 3), np.nan), MESH)
    assert (found.points.corners == -1).all()
    assert np.isnan(found.from_surface).all()


def test_landmarks_in_another_coordinate_system_are_refused_if_only_some_are_far() -> None:
    offset = (0.0, 0.15, 0.0)
    surface = moved(offset)
    right = PLACES + offset
    wrong = right * [-1.0, -1.0, 1.0]
    with pytest.raises(MisplacedLandmarks, match=r"^[1-5] of 6 .*, but none with x and y negated"):
        place_landmarks(LABELS, wrong, surface)
    # One that is misplaced does not turn the others.
    misplaced = right.copy()
    misplaced[0] *= 20.0
    (text,) = place_landmarks(LABELS, misplaced, surface).remarks
    assert text.startswith("1 of 6 landmarks is far from the surface, 'p0' by ")


def test_landmarks_beside_the_surface_are_reported_if_negating_brings_them_nearer() -> None:
    """As on a bone that is round about the z axis: none is far."""
    offset = (0.05, 0.0, 0.0)
    surface = moved(offset)
    right = PLACES + offset
    assert place_landmarks(LABELS, right, surface).remarks == ()
    found = place_landmarks(LABELS, right * [-1.0, -1.0, 1.0], surface)
    assert not np.isnan(found.from_surface).any()
    (text,) = found.remarks
    assert text.startswith("the landmarks lie beside the surface; with x and y negated")


def test_labels_that_recur_are_reported() -> None:
    found = place_landmarks(("p", "q", "p", None, None, "p"), PLACES, MESH)
    assert found.remarks == ("3 landmarks are called 'p'; only their order tells them apart",)
