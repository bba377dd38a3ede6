"""Fast marching: exact where the surface unfolds, accurate elsewhere."""

import heapq

import numpy as np
import pytest

from bench.geodesics import exact_distances
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.geodesics import FastMarching, GeodesicGraph
from solver.shape.geodesics.graph import segments
from solver.shape.geodesics.intrinsic import intrinsic_triangulation
from tests.solver import shapes
from tests.solver.shape.geodesics import surfaces


def errors(mesh: TriangleMesh, count: int = 8) -> FloatArray:
    """Relative errors."""
    sources = np.arange(0, mesh.n_vertices, max(mesh.n_vertices // count, 1))
    exact = exact_distances(mesh, sources)
    apart = exact > 0.0
    found: FloatArray = FastMarching(mesh).distances(sources)[apart] / exact[apart] - 1.0
    return found


@pytest.mark.parametrize("stretch", [1.0, 100.0])
def test_plane(stretch: float) -> None:
    """Circular wavefronts are exact there, on any triangles."""
    for mesh in (surfaces.random_rectangle(stretch), shapes.plane_grid(31, 21, stretch)):
        sources = np.arange(0, mesh.n_vertices, 41)
        exact = surfaces.straight(mesh, sources)
        found = FastMarching(mesh).distances(sources)
        np.testing.assert_allclose(found, exact, rtol=1e-4)
        assert (found >= exact * (1.0 - 1e-9)).all()


def test_prism() -> None:
    mesh, exact = surfaces.prism()
    found = FastMarching(mesh).distances(np.arange(mesh.n_vertices))
    np.testing.assert_allclose(found, exact, rtol=0.01, atol=1e-12)
    assert np.mean(found - exact) < 0.001 * exact.mean()


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
    found = FastMarching(mesh).distances(sources)
    apart = exact > 0.0
    relative = np.abs(found[apart] / exact[apart] - 1.0)
    assert relative.mean() <= 0.002
    assert relative.max() <= 0.06


def test_round_a_corner_of_the_boundary() -> None:
    mesh = surfaces.bent_rectangle()
    sources = np.arange(0, mesh.n_vertices, 7)
    exact = surfaces.around_the_corner(mesh, sources)
    found = FastMarching(mesh).distances(sources)
    apart = exact > 0.0
    relative = np.abs(found[apart] / exact[apart] - 1.0)
    assert relative.mean() <= 0.001
    assert relative.max() <= 0.02


def test_cube_from_a_corner() -> None:
    mesh = shapes.cube(5)
    corner = int(np.argmin(mesh.vertices.sum(axis=1)))
    found = FastMarching(mesh).distances(np.array([corner]))[0]
    np.testing.assert_allclose(found, surfaces.cube_from_corner(mesh.vertices), rtol=1e-12)


def test_sheets_that_meet_in_one_line() -> None:
    """Every edge on the line has three triangles; any two sheets make a plane."""
    mesh = shapes.three_sheets()
    x, y, z = mesh.vertices.T
    radius, sheet = np.hypot(x, y), np.round(np.arctan2(y, x), 6)
    sheet[radius < 1e-9] = np.nan  # on all of them
    same = sheet[:, None] == sheet
    across = np.where(same, np.abs(radius[:, None] - radius), np.abs(radius[:, None] + radius))
    exact = np.hypot(across, z[:, None] - z)
    np.testing.assert_allclose(
        FastMarching(mesh).distances(np.arange(mesh.n_vertices)), exact, rtol=1e-9, atol=1e-12
    )


def test_cones_that_touch_in_one_point() -> None:
    """Shortest paths from one to the other lead through it, however sharp they are."""
    mesh, distance, _ = surfaces.cone(4, 0.2)
    count = mesh.n_vertices
    second = mesh.faces + count - 1
    second[mesh.faces == 0] = 0
    double = triangle_mesh(
        np.concatenate([mesh.vertices, -mesh.vertices[1:]]), np.concatenate([mesh.faces, second])
    )
    sources = np.array([0, 1, 9, 20])
    found = FastMarching(double).distances(sources)
    through = distance[sources][:, None] + distance[1:]
    np.testing.assert_allclose(found[:, count:], through, rtol=1e-3)


def test_sphere_converges() -> None:
    """Great circles: the error falls with the size of the triangles."""
    means = []
    for subdivisions in (2, 3, 4):
        mesh = shapes.icosphere(subdivisions)
        exact = np.arccos(np.clip(mesh.vertices[:12] @ mesh.vertices.T, -1.0, 1.0))
        found = FastMarching(mesh).distances(np.arange(12))
        means.append(float(np.abs(found - exact)[exact > 0].mean()))
    assert means[0] > 1.9 * means[1] > 3.6 * means[2]
    assert means[2] < 0.004 * np.pi / 2


@pytest.mark.parametrize(
    ("name", "mean", "greatest"),
    [
        ("blob", 0.003, 0.06),
        ("torus", 0.006, 0.05),
        ("moebius_strip", 0.004, 0.03),
        ("cube", 0.006, 0.15),
        ("tetrahedron", 1e-9, 1e-9),
        ("triangle", 1e-9, 1e-9),
    ],
)
def test_near_exact_distances(name: str, mean: float, greatest: float) -> None:
    found = np.abs(errors(shapes.CONNECTED[name]()))
    assert found.mean() <= mean
    assert found.max() <= greatest


def test_more_accurate_than_the_graph() -> None:
    """Also on a surface so rough that wavefronts are hardly circular."""
    sphere = shapes.icosphere(3)
    noise = np.random.default_rng(0).standard_normal((sphere.n_vertices, 1))
    for roughness in (0.0, 0.005, 0.05):
        mesh = triangle_mesh(sphere.vertices * (1.0 + roughness * noise), sphere.faces)
        sources = np.arange(0, mesh.n_vertices, 80)
        exact = exact_distances(mesh, sources)
        marched, walked = (
            np.abs(method(mesh).distances(sources) - exact).mean()
            for method in (FastMarching, GeodesicGraph)
        )
        assert 2.5 * marched < walked


def test_thin_triangles() -> None:
    sphere = shapes.icosphere(3)
    mesh = triangle_mesh(sphere.vertices * np.array([1.0, 0.05, 20.0]), sphere.faces)
    assert np.abs(errors(mesh)).mean() < 0.003


def test_thin_triangles_that_cannot_be_flipped() -> None:
    """Neighbours wind inconsistently, which a mesh read from a file would not do."""
    sphere = shapes.icosphere(3)
    stretched = sphere.vertices * np.array([1.0, 0.05, 20.0])
    turned = np.arange(sphere.n_faces) % 2 == 0
    faces = np.where(turned[:, None], sphere.faces[:, ::-1], sphere.faces)
    mesh = triangle_mesh(stretched, faces.copy())
    sources = np.array([0, 300])
    exact = exact_distances(triangle_mesh(stretched, sphere.faces), sources)
    found = FastMarching(mesh).distances(sources)
    apart = exact > 0.0
    assert np.abs(found[apart] / exact[apart] - 1.0).mean() < 0.01


def reference_march(mesh: TriangleMesh, source: int) -> FloatArray:
    """Plain implementation with Python's heap and complex numbers for the plane."""
    triangulation = intrinsic_triangulation(mesh).delaunay()
    graph = segments(mesh, triangulation)
    lengths = triangulation.lengths.reshape(-1, 3)
    distances = np.full(mesh.n_vertices, np.inf)
    distances[source] = 0.0
    queue = [(0.0, source)]
    waiting = {source}

    def lower(vertex: int, found: float) -> None:
        if found < (1.0 - 1e-12) * distances[vertex]:
            distances[vertex] = found
            waiting.add(vertex)
            heapq.heappush(queue, (found, vertex))

    while queue:
        distance, here = heapq.heappop(queue)
        if here not in waiting or distance > distances[here]:
            continue
        waiting.discard(here)
        row = slice(graph.indptr[here], graph.indptr[here + 1])
        for there, length in zip(graph.indices[row], graph.data[row], strict=True):
            lower(int(there), distance + length)
        for face, corner in np.argwhere(triangulation.faces == here):
            for turn in (1, 2):
                other, there = triangulation.faces[face, [(corner + turn) % 3, (corner - turn) % 3]]
                if other in waiting or not np.isfinite(distances[other]):
                    continue
                base = lengths[face, corner if turn == 1 else (corner + 2) % 3]
                arm = lengths[face, (corner + 2) % 3 if turn == 1 else corner]
                far = lengths[face, (corner + 1) % 3]
                apex = circles_meet(base, arm, far)
                origin = circles_meet(base, distances[here], distances[other]).conjugate()
                if origin.imag < 0.0:
                    crossing = (apex.real * -origin.imag + origin.real * apex.imag) / (
                        apex.imag - origin.imag
                    )
                    if 0.0 < crossing < base:
                        lower(int(there), abs(apex - origin))
    return distances


def circles_meet(base: float, left: float, right: float) -> complex:
    """Where circles of two radii round 0 and `base` meet, above; on the line if they do not."""
    along = (base**2 + left**2 - right**2) / (2.0 * base)
    return complex(along, np.sqrt(max(left**2 - along**2, 0.0)))


@pytest.mark.parametrize("name", ["blob", "torus", "three_sheets", "moebius_strip", "plane_grid"])
def test_equals_the_reference_implementation(name: str) -> None:
    mesh = shapes.icosphere(1) if name == "blob" else shapes.CONNECTED[name]()
    if name == "blob":
        scale = np.random.default_rng(1).uniform(0.7, 1.3, (mesh.n_vertices, 1))
        mesh = triangle_mesh(mesh.vertices * scale, mesh.faces)
    marching = FastMarching(mesh)
    for source in (0, mesh.n_vertices // 2):
        np.testing.assert_allclose(
            marching.distances(np.array([source]))[0], reference_march(mesh, source), rtol=1e-11
        )
