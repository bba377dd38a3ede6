"""Carried landmarks: round trips, distortion, and the confidence that they give."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.arrays import BoolArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration import DenseCorrespondence
from solver.transfer import Landmarks, carry_landmarks, landmark_confidence, local_distortion
from tests.solver.transfer.maps import MESH

TURN = Rotation.from_rotvec([0.4, -1.0, 2.0]).as_matrix()
SHIFT = np.array([5.0, 1.0, -2.0])
TURNED = MESH.with_same_faces(vertices=3.0 * MESH.vertices @ TURN.T + SHIFT)
BENT = MESH.with_same_faces(
    vertices=MESH.vertices + 0.4 * np.sin(2.0 * MESH.vertices[:, [1, 2, 0]]) * [1.0, 0.5, -1.0]
)
RANDOM = np.random.default_rng(2)
POINTS = Landmarks(MESH.faces[:60:10], RANDOM.dirichlet(np.ones(3), size=6))
PLACES = POINTS.positions(MESH)
SIZE = float(np.sqrt(MESH.area))


def identity(vertices: IntArray | BoolArray | None = None) -> DenseCorrespondence:
    """The map of all or some vertices of the mesh, to themselves."""
    corners = np.zeros((MESH.n_vertices, 3), dtype=np.int64)
    for face in MESH.faces:
        corners[face] = face
    ids = np.arange(MESH.n_vertices)
    weights = (corners == ids[:, None]).astype(np.float64)
    kept = ids if vertices is None else ids[vertices]
    return DenseCorrespondence(kept, kept, corners[kept], weights[kept])


WHOLE = identity(), identity()
LOW = MESH.vertices[:, 2] < 0.3 * MESH.vertices[:, 2].max()


def test_a_similarity_carries_exactly() -> None:
    found = carry_landmarks(POINTS, WHOLE, MESH, TURNED)
    np.testing.assert_allclose(
        found.images.positions(TURNED), 3.0 * PLACES @ TURN.T + SHIFT, atol=1e-9
    )
    np.testing.assert_allclose(found.round_trip, 0.0, atol=1e-9)
    np.testing.assert_allclose(found.distortion, 0.0, atol=1e-7)


def test_round_trips_are_distances_on_the_source() -> None:
    """The map back is one step too far: from the image of vertex i to that of i + 1."""
    back = identity()
    corners = np.repeat(((back.source + 1) % MESH.n_vertices)[:, None], 3, axis=1)
    astray = DenseCorrespondence(back.source, back.target, corners, back.barycentric)
    vertices = np.array([3, 99, 400])
    at = Landmarks(np.repeat(vertices[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (3, 1)))
    found = carry_landmarks(at, (identity(), astray), MESH, TURNED)
    expected = np.linalg.norm(MESH.vertices[vertices + 1] - MESH.vertices[vertices], axis=1)
    np.testing.assert_allclose(found.round_trip, expected / SIZE)


def test_landmarks_on_what_a_part_lacks_have_no_image_or_no_round_trip() -> None:
    inside, edge, outside = (
        Landmarks(face[None], np.full((1, 3), 1 / 3))
        for face in (
            MESH.faces[LOW[MESH.faces].all(axis=1)][0],
            MESH.faces[LOW[MESH.faces].any(axis=1) & ~LOW[MESH.faces].all(axis=1)][0],
            MESH.faces[~LOW[MESH.faces].any(axis=1)][0],
        )
    )
    every = Landmarks(
        np.concatenate([one.corners for one in (inside, edge, outside)]), np.full((3, 3), 1 / 3)
    )
    there = carry_landmarks(every, (identity(LOW), identity()), MESH, TURNED)
    assert (there.images.corners == -1).all(axis=1).tolist() == [False, True, True]
    assert np.isnan(there.distortion).tolist() == [False, True, True]
    back = carry_landmarks(every, (identity(), identity(LOW)), MESH, TURNED)
    assert (back.images.corners >= 0).all()
    assert np.isnan(back.round_trip).tolist() == [False, True, True]
    sure = landmark_confidence(0.9, back.round_trip, back.distortion)
    assert np.isnan(sure).tolist() == [False, True, True]


def test_distortion_is_that_of_the_best_rotation() -> None:
    assert (local_distortion(PLACES, MESH, identity(), TURNED) < 1e-7).all()
    found = local_distortion(PLACES, MESH, identity(), BENT)
    turns = Rotation.random(300, rng=np.random.default_rng(1)).as_matrix()
    for place, value in zip(PLACES, found, strict=True):
        # The blob has no limbs, so that what is near in space is near on the surface.
        near = np.linalg.norm(MESH.vertices - place, axis=1) <= 0.1 * SIZE
        here, there = MESH.vertices[near] / SIZE, BENT.vertices[near] / np.sqrt(BENT.area)
        here, there = here - here.mean(axis=0), there - there.mean(axis=0)
        apart = np.linalg.norm(here @ turns - there, axis=2)
        assert 0.0 < value <= np.sqrt((apart**2).mean(axis=1)).min() / 0.1 + 1e-9


def test_a_part_is_not_distorted_at_its_scale() -> None:
    """Its area is not that of the target."""
    part = triangle_mesh(MESH.vertices, MESH.faces[LOW[MESH.faces].all(axis=1)])
    point = MESH.vertices[[MESH.vertices[:, 2].argmin()]]
    there = identity(part.vertex_ids)
    assert local_distortion(point, part, there, TURNED, 3.0).max() < 1e-7
    assert local_distortion(point, part, there, TURNED).min() > 0.05


def test_parts_near_in_space_alone_do_not_count() -> None:
    """Two sheets that nearly touch, of which one is moved."""
    grid = np.stack(np.meshgrid(np.arange(4.0), np.arange(4.0)), axis=2).reshape(-1, 2)
    rows = [4 * y + x for y in range(3) for x in range(3)]
    faces = np.array([(a, a + 1, a + 4) for a in rows] + [(a + 1, a + 5, a + 4) for a in rows])
    sheets = [np.column_stack([grid, np.full(16, height)]) for height in (0.0, 0.01, 3.0)]

    def both(first: int, second: int) -> TriangleMesh:
        vertices = np.vstack([sheets[first], sheets[second]])
        return triangle_mesh(vertices, np.vstack([faces, faces + 16]))

    ids = np.arange(32)
    alone = np.tile([1.0, 0.0, 0.0], (32, 1))
    along = DenseCorrespondence(ids, ids, np.repeat(ids[:, None], 3, axis=1), alone)
    middle = sheets[0][[5]]
    assert local_distortion(middle, both(0, 1), along, both(0, 2), 1.0).max() < 1e-7


def test_a_map_of_no_face_has_no_distortion() -> None:
    few = identity(np.array([0]))
    assert np.isnan(local_distortion(PLACES, MESH, few, TURNED)).all()


@pytest.mark.parametrize("probability", [0.2, 0.99])
def test_confidence_falls_with_doubt_round_trip_and_distortion(probability: float) -> None:
    some, none = np.linspace(0.0, 0.3, 7), np.zeros(7)
    for trips, changes in ((some, none), (none, some)):
        values = landmark_confidence(probability, trips, changes)
        assert (np.diff(values) < 0.0).all()
        assert ((values > 0.0) & (values < probability)).all()
