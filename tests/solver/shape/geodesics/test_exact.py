"""Exact geodesic distances: closed forms, and all straight lines tried out on small surfaces."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.geodesics import ExactGeodesics, GeodesicGraph
from tests.solver import shapes
from tests.solver.shape.geodesics import surfaces
from tests.solver.shape.geodesics.straight_lines import straight_lines


def every(mesh: TriangleMesh, step: int = 1) -> FloatArray:
    return ExactGeodesics(mesh).distances(np.arange(0, mesh.n_vertices, step))


@pytest.mark.parametrize("stretch", [1.0, 100.0])
def test_plane(stretch: float) -> None:
    """Also of triangles that are a hundred times longer than high."""
    for mesh in (surfaces.random_rectangle(stretch), shapes.plane_grid(16, 11, stretch)):
        sources = np.arange(0, mesh.n_vertices, 29)
        np.testing.assert_allclose(
            ExactGeodesics(mesh).distances(sources),
            surfaces.straight(mesh, sources),
            rtol=1e-9,
            atol=1e-12,
        )


def test_cube() -> None:
    for cells in (1, 2, 5):
        mesh = shapes.cube(cells)
        corner = int(np.argmin(mesh.vertices.sum(axis=1)))
        found = ExactGeodesics(mesh).distances(np.array([corner]))[0]
        np.testing.assert_allclose(found, surfaces.cube_from_corner(mesh.vertices), rtol=1e-9)


def test_tetrahedron() -> None:
    """Its surface is the plane folded up: a torus, of which ±z are one point."""
    mesh = shapes.fine_tetrahedron(2)
    edge, height = np.sqrt(2.0), np.sqrt(1.5)
    a, b, c = np.array([[0.0, 0.0], [edge, 0.0], [edge / 2, height]])
    corners = shapes.tetrahedron().vertices
    faces = {0: (a, b, c), 1: (a, b - c, b), 2: (c, b, b + c), 3: (a, c, c - b)}
    unfolded = np.full((mesh.n_vertices, 2), np.nan)
    for number, names in enumerate([(0, 1, 2), (0, 3, 1), (2, 1, 3), (0, 2, 3)]):
        weights = np.linalg.lstsq(
            np.vstack([corners[list(names)].T, np.ones(3)]),
            np.vstack([mesh.vertices.T, np.ones(mesh.n_vertices)]),
            rcond=None,
        )[0].T
        on = (weights > -1e-9).all(axis=1) & np.isclose(
            weights @ corners[list(names)], mesh.vertices
        ).all(axis=1)
        unfolded[on] = weights[on] @ np.array(faces[number])
    images = [
        sign * unfolded + 2.0 * (i * b + j * c)
        for sign in (1, -1)
        for i in range(-2, 3)
        for j in range(-2, 3)
    ]
    exact = np.min([np.linalg.norm(unfolded[:, None] - image, axis=2) for image in images], axis=0)
    np.testing.assert_allclose(every(mesh), exact, atol=1e-12)


@pytest.mark.parametrize(
    ("sectors", "angle"),
    [(4, 0.2), (5, 0.9), (7, 0.85), (6, 1.5), (12, 0.9)],
    ids=["needle", "hat", "flat", "saddle", "ruffle"],
)
def test_cone(sectors: int, angle: float) -> None:
    """Around the apex of a saddle, shortest paths turn there."""
    mesh, distance, direction = surfaces.cone(sectors, angle)
    sources = np.arange(0, mesh.n_vertices, 5)
    exact = surfaces.cone_distances(distance, direction, sectors * angle, sources)
    np.testing.assert_allclose(ExactGeodesics(mesh).distances(sources), exact, atol=1e-12)


def test_prism() -> None:
    mesh, exact = surfaces.prism()
    np.testing.assert_allclose(every(mesh), exact, atol=1e-12)


def test_round_a_corner_of_the_boundary() -> None:
    mesh = surfaces.bent_rectangle()
    sources = np.arange(0, mesh.n_vertices, 7)
    exact = surfaces.around_the_corner(mesh, sources)
    np.testing.assert_allclose(ExactGeodesics(mesh).distances(sources), exact, atol=1e-12)


def test_sheets_that_meet_in_one_line() -> None:
    """Every edge on the line has three triangles; any two sheets make a plane."""
    mesh = shapes.three_sheets()
    x, y, z = mesh.vertices.T
    radius, sheet = np.hypot(x, y), np.round(np.arctan2(y, x), 6)
    sheet[radius < 1e-9] = np.nan  # on all of them
    same = sheet[:, None] == sheet
    across = np.where(same, np.abs(radius[:, None] - radius), np.abs(radius[:, None] + radius))
    np.testing.assert_allclose(every(mesh), np.hypot(across, z[:, None] - z), atol=1e-12)


def test_cones_that_touch_in_one_point() -> None:
    """The only way from one to the other leads through it, however sharp they are."""
    mesh, distance, direction = surfaces.cone(4, 0.2)
    count = mesh.n_vertices
    second = mesh.faces + count - 1
    second[mesh.faces == 0] = 0
    double = triangle_mesh(
        np.concatenate([mesh.vertices, -mesh.vertices[1:]]), np.concatenate([mesh.faces, second])
    )
    sources = np.array([0, 1, 9, 20])
    found = ExactGeodesics(double).distances(sources)
    alone = surfaces.cone_distances(distance, direction, 0.8, sources)
    np.testing.assert_allclose(found[:, :count], alone, atol=1e-12)
    through = distance[sources][:, None] + distance[1:]
    np.testing.assert_allclose(found[:, count:], through, atol=1e-12)


def test_sphere() -> None:
    """Polyhedra with ever smaller triangles: second order."""
    errors = []
    for subdivisions in (1, 2, 3):
        mesh = shapes.icosphere(subdivisions)
        sources = np.arange(12)
        exact = np.arccos(np.clip(mesh.vertices[sources] @ mesh.vertices.T, -1.0, 1.0))
        found = ExactGeodesics(mesh).distances(sources)
        errors.append(float(np.abs(found - exact).max()))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_a_metric_that_no_path_undercuts(name: str) -> None:
    mesh = shapes.CONNECTED[name]()
    sources = np.arange(0, mesh.n_vertices, max(mesh.n_vertices // 12, 1))
    found = ExactGeodesics(mesh).distances(sources)
    between = found[:, sources]
    scale = found.max()
    np.testing.assert_allclose(between, between.T, atol=1e-11 * scale)
    assert (found[:, None] <= between[:, :, None] + found[None] + 1e-11 * scale).all()
    assert (GeodesicGraph(mesh).distances(sources) >= found * (1.0 - 1e-11)).all()
    assert (found >= surfaces.straight(mesh, sources) - 1e-11 * scale).all()


@pytest.mark.parametrize("seed", range(6))
def test_all_lines_tried_out(seed: int) -> None:
    """A shortest path is a chain of straight lines from vertex to vertex."""
    rng = np.random.default_rng(seed)
    sphere = shapes.icosphere(0)
    mesh = triangle_mesh(
        sphere.vertices * rng.uniform(0.3, 2.0, (12, 1)),
        sphere.faces[seed % 3 :],  # some with a hole
    )
    shortest = straight_lines(mesh)
    for way in range(mesh.n_vertices):
        shortest = np.minimum(shortest, shortest[:, way : way + 1] + shortest[way])
    np.testing.assert_allclose(every(mesh), shortest, rtol=1e-11)
