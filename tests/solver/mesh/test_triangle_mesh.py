"""TriangleMesh: checks, repairs, measures and components."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import MeshError
from solver.mesh import TriangleMesh, largest_component, triangle_areas, triangle_mesh
from solver.mesh.edges import non_manifold_vertices
from synthetic import glued, punched
from tests.solver import shapes

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    ("mesh", "area", "components", "closed"),
    [
        (shapes.cube(), 6.0, 1, True),
        (shapes.plane_grid(width=1.5), 1.5, 1, False),
        (shapes.tetrahedron(), 2.0 * np.sqrt(3.0), 1, True),
        (shapes.triangle(), 0.5, 1, False),
        (shapes.two_components(), shapes.icosphere(2).area + 6.0, 2, True),
    ],
)
def test_area_components_and_boundary(
    mesh: TriangleMesh, area: float, components: int, closed: bool
) -> None:
    assert mesh.area == pytest.approx(area, rel=1e-9)
    assert mesh.components == components
    assert mesh.closed is closed
    assert len(mesh.warnings) == components - 1


def test_area_approaches_that_of_the_sphere() -> None:
    errors = [1.0 - shapes.icosphere(n).area / (4.0 * np.pi) for n in (2, 3, 4)]
    assert errors[0] > errors[1] > errors[2] > 0.0
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.02)  # second order


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_euler_characteristic(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    expected = {"icosphere": 2, "cube": 2, "blob": 2, "tetrahedron": 2, "plane_grid": 1}
    expected |= {"triangle": 1, "torus": 0, "tube": 0, "moebius_strip": 0, "three_sheets": 1}
    assert mesh.n_vertices - len(mesh.edges) + mesh.n_faces == expected[name]


@pytest.mark.parametrize(
    ("mesh", "genus"),
    [
        (shapes.cube(), 0),
        (shapes.torus(), 1),
        (shapes.plane_grid(), 0),
        (shapes.tube(), 0),
        (shapes.two_components(), 0),
        (glued(shapes.blob(), np.array([[0, 100], [300, 500]]), 0.2).mesh, 2),
        (punched(shapes.torus(), np.array([0, 100]), 0.2).mesh, 1),
    ],
)
def test_genus_is_the_number_of_handles_whatever_the_holes(mesh: TriangleMesh, genus: int) -> None:
    assert mesh.genus == genus


@pytest.mark.parametrize("mesh", [shapes.plane_grid(), shapes.icosphere(2)])
def test_holes_that_touch_at_a_vertex_are_no_handle(mesh: TriangleMesh) -> None:
    rng = np.random.default_rng(5)
    pinched = 0
    for _ in range(20):
        found = triangle_mesh(mesh.vertices, mesh.faces[rng.random(mesh.n_faces) < 0.8])
        pinched += len(non_manifold_vertices(found.faces, found.face_edges)) > 0
        assert found.genus == 0.0
    assert pinched >= 15


def test_surfaces_that_touch_at_a_vertex_are_two() -> None:
    ball = shapes.icosphere(2)
    faces = np.concatenate([ball.faces, ball.faces + ball.n_vertices - 1])
    beside = ball.vertices - ball.vertices[0] + ball.vertices[-1]
    vertices = np.concatenate([ball.vertices, beside[1:]])
    assert triangle_mesh(vertices, faces).genus == 0.0


def test_the_mean_edge_of_a_corner_of_a_cube() -> None:
    corner = triangle_mesh(
        np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]]),
        np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    )
    assert corner.mean_edge == pytest.approx(1.0 + np.sqrt(2.0))


def test_edges_are_unique_and_sorted() -> None:
    edges = shapes.cube().edges
    assert (edges[:, 0] < edges[:, 1]).all()
    assert (np.diff(edges[:, 0] * shapes.cube().n_vertices + edges[:, 1]) > 0).all()


def test_repairs_are_made_and_recorded() -> None:
    vertices = np.concatenate([[[9.0, 9, 9]], SQUARE, [[0.5, 0.5, 0.0], [7.0, 7, 7]]])
    faces = np.array(
        [
            [1, 2, 3],
            [1, 3, 4],
            [1, 1, 2],  # repeats a vertex
            [1, 5, 3],  # its corners lie on a line
            [3, 1, 2],  # the first face again
            [2, 1, 3],  # and again, turned over
        ]
    )
    mesh = triangle_mesh(vertices, faces)
    np.testing.assert_array_equal(mesh.vertex_ids, [1, 2, 3, 4])
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(mesh.vertices, vertices[mesh.vertex_ids])
    assert mesh.area == 1.0
    assert mesh.warnings == (
        "dropped 1 face using a vertex twice",
        "dropped 1 face without area",
        "dropped 2 faces repeating others",
        "dropped 3 vertices that no face uses",
    )


def test_colors_follow_their_vertices() -> None:
    colors = np.array([[0.0, 0, 0], [0.25, 0, 0], [0.5, 0, 0], [0.75, 0, 0]])
    mesh = triangle_mesh(SQUARE, np.array([[1, 2, 3]]), colors)
    assert mesh.colors is not None
    np.testing.assert_array_equal(mesh.colors, colors[1:])


def test_whole_numbers_are_colors() -> None:
    """Means of merged vertices are none."""
    corners = np.concatenate([SQUARE[:3], SQUARE[[0, 2, 3]]])
    colors = np.array([3 * [0], 3 * [0], 3 * [0], 3 * [1], 3 * [0], 3 * [0]])
    mesh = triangle_mesh(corners, np.array([[0, 1, 2], [3, 4, 5]]), colors)
    assert mesh.colors is not None
    assert mesh.colors[0].tolist() == [0.5, 0.5, 0.5]


def test_an_unsound_face_far_from_the_origin_is_still_seen() -> None:
    """Repairs must not depend on where the shape lies or how large it is."""
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 4, 2]])
    points = np.concatenate([SQUARE, [[0.5, 0.5, 0.0]]])
    for scale, origin in [(1e-6, 0.0), (1e6, 0.0), (1.0, 2.0**20), (1e-60, 0.0), (1e60, 0.0)]:
        mesh = triangle_mesh(scale * points + origin, faces)
        assert mesh.n_faces == 2
        assert mesh.area == pytest.approx(scale**2, rel=1e-9)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "no vertices"),
        (SQUARE, np.zeros((0, 3), int), "no faces"),
        (SQUARE, [[0, 1, 4]], "outside 0..3"),
        (SQUARE, [[0, 1, -1]], "outside 0..3"),
        (SQUARE * [np.nan, 1, 1], [[0, 1, 2]], "vertex 0 has a coordinate that is not"),
        (SQUARE + np.inf, [[0, 1, 2]], "not a finite number"),
        (SQUARE * [1, 0, 0], [[0, 1, 2]], "no face has an area"),
        (SQUARE, [[0, 0, 1]], "no face has an area"),
        (SQUARE * 0.0, [[0, 1, 2]], "no extent"),
        (SQUARE * 1e200, [[0, 1, 2]], "too large or too small"),
        (SQUARE * 1e-200, [[0, 1, 2]], "too large or too small"),
        (SQUARE * 1.7e308 - 1e308, [[0, 1, 2], [0, 2, 3]], r"large|far apart"),
        (SQUARE[:, :2], [[0, 1, 2]], r"\(V, 3\)"),
        (SQUARE, [[0, 1]], r"\(F, 3\)"),
        (SQUARE, [[0.0, 1.0, 2.0]], "integers"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_unusable_arrays_are_refused(
    vertices: np.ndarray, faces: list[list[int]], message: str
) -> None:
    with pytest.raises(MeshError, match=message):
        triangle_mesh(vertices, np.array(faces))


@pytest.mark.parametrize(
    ("colors", "message"),
    [
        (np.zeros((3, 3)), "row for every vertex"),
        (np.full((4, 3), 255), "from 0 to 1"),
        (np.full((4, 3), np.nan), "from 0 to 1"),
        (np.full((4, 3), -0.1), "from 0 to 1"),
    ],
)
def test_unusable_colors_are_refused(colors: np.ndarray, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        triangle_mesh(SQUARE, np.array([[0, 1, 2]]), colors)


def test_largest_component_is_that_of_largest_area() -> None:
    both = shapes.two_components()
    kept = largest_component(both)
    assert kept.components == 1
    assert kept.area == pytest.approx(shapes.icosphere(2).area)
    np.testing.assert_array_equal(kept.vertex_ids, np.arange(shapes.icosphere(2).n_vertices))
    np.testing.assert_array_equal(kept.vertices, both.vertices[kept.vertex_ids])
    assert kept.warnings == ("only the largest of 2 components was kept: 67.3 % of the area",)
    assert largest_component(kept) is kept


def test_scaled_is_centred_and_similar() -> None:
    mesh = shapes.moved(shapes.blob(), seed=3, scale=1e3)
    unit = mesh.scaled(1.0 / np.sqrt(mesh.area))
    assert unit.area == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(unit.vertices.max(axis=0), -unit.vertices.min(axis=0), atol=1e-12)
    np.testing.assert_array_equal(unit.faces, mesh.faces)


def test_scaled_keeps_what_is_known_of_the_faces() -> None:
    mesh = shapes.two_components()
    scaled, fresh = mesh.scaled(3.0), replace(mesh.scaled(3.0))
    assert mesh.components == scaled.components == fresh.components == 2
    assert mesh.edges is mesh.scaled(2.0).edges
    np.testing.assert_array_equal(scaled.edges, fresh.edges)
    for known, plain in zip(mesh.neighbours, fresh.neighbours, strict=True):
        np.testing.assert_array_equal(known, plain)


@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 30))
def test_whatever_the_arrays_the_mesh_is_sound(seed: int, n_vertices: int, n_faces: int) -> None:
    random = np.random.default_rng(seed)
    vertices = random.integers(-2, 3, (n_vertices, 3)).astype(np.float64)
    faces = random.integers(0, n_vertices, (n_faces, 3))
    try:
        mesh = triangle_mesh(vertices, faces)
    except MeshError:
        a, b, c = (vertices[faces[:, corner]] for corner in range(3))
        assert not np.cross(b - a, c - a).any()
        return
    np.testing.assert_array_equal(np.unique(mesh.faces), np.arange(mesh.n_vertices))
    np.testing.assert_array_equal(mesh.vertices, vertices[mesh.vertex_ids])
    corners = {tuple(sorted(face)) for face in mesh.faces.tolist()}
    assert len(corners) == mesh.n_faces
    assert all(len(set(face)) == 3 for face in corners)
    assert (triangle_areas(mesh.vertices, mesh.faces) > 0.0).all()
    # Nothing is made up.
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    assert mesh.area <= 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() + 1e-9
    if not any("cracks" in warning for warning in mesh.warnings):
        given_places = {frozenset(map(tuple, corners)) for corners in vertices[faces].tolist()}
        kept = {frozenset(map(tuple, corners)) for corners in mesh.vertices[mesh.faces].tolist()}
        assert kept <= given_places


def test_small_holes_are_no_cuts() -> None:
    """Holes of one triangle, however large, and those that are short."""
    cap = shapes.spherical_cap(np.pi / 2)
    inner = cap.faces[~cap.on_boundary[cap.faces].any(axis=1)]
    apart, touched = [], np.zeros(cap.n_vertices, dtype=np.bool_)
    for face in inner:
        if not touched[face].any():
            apart.append(face)
            touched[face] = True
    left = [face for face in cap.faces.tolist() if face not in np.array(apart[:40]).tolist()]
    holed = triangle_mesh(cap.vertices, np.array(left))
    assert holed.on_boundary.sum() == cap.on_boundary.sum() + 120
    np.testing.assert_array_equal(holed.on_cut, cap.on_boundary)
    rim = cap.relative_boundary * np.sqrt(cap.area / holed.area)
    assert holed.relative_boundary == pytest.approx(rim)
    grid = shapes.plane_grid(80, 80, 1.0)
    missing = np.linalg.norm(grid.vertices - grid.vertices.mean(axis=0), axis=1).argmin()
    pierced = triangle_mesh(grid.vertices, grid.faces[(grid.faces != missing).all(axis=1)])
    assert pierced.on_boundary.sum() > pierced.on_cut.sum() == grid.on_cut.sum()


def test_a_hemisphere_has_the_boundary_of_its_circle() -> None:
    cap = shapes.spherical_cap(np.pi / 2)
    assert cap.relative_boundary == pytest.approx(np.sqrt(2 * np.pi), rel=0.01)
    assert cap.longest_cut == pytest.approx(cap.relative_boundary)
    assert shapes.icosphere().relative_boundary == shapes.icosphere().longest_cut == 0.0
