"""Surfaces of point clouds: closed forms, ground truth, and clouds that have none."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial import ConvexHull, KDTree

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.matching import MatchOptions, match
from solver.mesh import (
    TriangleMesh,
    face_normals,
    read_mesh,
    simplified,
    triangle_mesh,
    vertex_normals,
)
from solver.mesh.edges import edges_of, non_manifold_vertices
from solver.shape import Shape
from synthetic import human
from tests.solver import shapes


def ply(points: FloatArray, columns: tuple[str, ...] = ("x", "y", "z")) -> bytes:
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    header += [f"property double {name}" for name in columns]
    return ("\n".join([*header, "end_header\n"])).encode() + points.astype("<f8").tobytes()


def cloud(points: FloatArray) -> TriangleMesh:
    return read_mesh(ply(points), "ply")


def on_sphere(count: int, seed: int = 1) -> FloatArray:
    points = np.random.default_rng(seed).standard_normal((count, 3))
    unit: FloatArray = points / np.linalg.norm(points, axis=1, keepdims=True)
    return unit


def helix(count: int) -> FloatArray:
    angle = np.linspace(0.0, 9.0, count)
    return np.stack([np.cos(angle), np.sin(angle), angle], axis=1)


def test_a_sphere_is_the_convex_hull_of_its_points() -> None:
    """Triangles of a Delaunay triangulation on the sphere are the faces of the hull."""
    points = on_sphere(2000)
    mesh = cloud(points)
    assert mesh.is_cloud
    assert simplified(mesh, 500).is_cloud
    assert (mesh.closed, mesh.components, mesh.n_faces) == (True, 1, 2 * 2000 - 4)
    np.testing.assert_array_equal(mesh.vertices, points)
    np.testing.assert_array_equal(mesh.vertex_ids, np.arange(2000))
    hull = {frozenset(face) for face in ConvexHull(points).simplices.tolist()}
    own = {frozenset(face) for face in mesh.faces.tolist()}
    assert len(own & hull) > 0.97 * len(hull)
    outwards = np.einsum("ij,ij->i", vertex_normals(points, mesh.faces), points)
    assert outwards.min() > 0.0
    assert mesh.warnings == (f"a surface of {mesh.n_faces} triangles was made of the points",)


def test_a_rectangle_has_its_area_and_no_triangle_twice() -> None:
    points = np.random.default_rng(2).random((1500, 3)) * [2.0, 1.0, 0.0]
    mesh = cloud(points)
    assert mesh.area == pytest.approx(2.0, rel=0.05)
    assert mesh.area <= 2.0 + 1e-9
    assert edges_of(mesh.faces).counts.max() == 2
    heights = vertex_normals(mesh.vertices, mesh.faces)[:, 2]
    assert np.ptp(heights) < 1e-9


@pytest.mark.parametrize("make", [lambda: shapes.torus(48, 24), shapes.plane_grid, shapes.cube])
def test_points_of_a_regular_grid_agree_on_diagonals(make: Callable[[], TriangleMesh]) -> None:
    """Four points on a circle have two Delaunay triangulations."""
    whole = make()
    mesh = cloud(whole.vertices)
    assert (mesh.closed, mesh.n_faces) == (whole.closed, whole.n_faces)
    assert mesh.area == pytest.approx(whole.area, rel=0.02)


def test_noise_changes_the_connectivity_little() -> None:
    points = on_sphere(2000)
    noisy = points + 0.005 * np.random.default_rng(3).standard_normal(points.shape)
    own, other = (
        {frozenset(face) for face in cloud(one).faces.tolist()} for one in (points, noisy)
    )
    assert len(own & other) > 0.7 * len(own)
    np.testing.assert_array_equal(cloud(noisy).vertices, noisy)


def test_scale_and_place_do_not_matter() -> None:
    points = shapes.blob(4).vertices
    expected = cloud(points).faces
    for scale in (1e-20, 1e20):
        np.testing.assert_array_equal(cloud(scale * (points + 1.0)).faces, expected)


def test_given_normals_say_which_side_is_outside() -> None:
    points = on_sphere(800)
    half = points[points[:, 2] > -0.2]
    columns = ("x", "y", "z", "nx", "ny", "nz")
    for sign in (1.0, -1.0):
        mesh = read_mesh(ply(np.hstack([half, sign * half]), columns), "ply")
        along = np.einsum("ij,ij->i", vertex_normals(mesh.vertices, mesh.faces), mesh.vertices)
        assert (sign * along).min() > 0.0


def test_points_without_a_normal_follow_those_that_have_one() -> None:
    points = on_sphere(800)
    half = points[points[:, 2] > -0.2]
    normals = -half
    normals[::3] = 0.0
    normals[1::7] = np.nan
    mesh = read_mesh(ply(np.hstack([half, normals]), ("x", "y", "z", "nx", "ny", "nz")), "ply")
    along = np.einsum("ij,ij->i", vertex_normals(mesh.vertices, mesh.faces), mesh.vertices)
    assert along.max() < 0.0


def test_defects_of_the_surface_are_not_those_of_the_points() -> None:
    """The user cannot mend what is no property of the points."""
    mesh = cloud(human(resolution=1000, seed=2).vertices)
    assert len(non_manifold_vertices(mesh.faces, mesh.soup().edges)) > 0
    for said in ("manifold", "winding", "inside out", "orientable"):
        assert not any(said in warning for warning in mesh.warnings)


def test_points_off_the_surface_are_those_nearest_on_it() -> None:
    points = human(resolution=3000, seed=2).vertices
    mesh = cloud(points)
    off = np.setdiff1d(np.arange(len(points)), mesh.vertex_ids)
    nearest = KDTree(mesh.vertices).query(points[off])[1]
    np.testing.assert_array_equal(mesh.vertices_of(off), nearest)
    assert f"merged {len(off)} points off the surface with the nearest on it" in mesh.warnings


def test_outliers_and_repeated_points_are_left_out_with_a_warning() -> None:
    points = on_sphere(1000)
    far = 5.0 * on_sphere(7, seed=5)
    lost = np.full((2, 3), np.nan)
    mesh = cloud(np.concatenate([far, points, points[:30], lost]))
    assert (mesh.closed, mesh.n_vertices) == (True, 1000)
    np.testing.assert_array_equal(mesh.vertex_ids, np.arange(7, 1007))
    np.testing.assert_array_equal(mesh.vertices_of(np.arange(1007, 1037)), np.arange(30))
    assert (mesh.vertices_of(np.array([0, 6, 1037, 1038])) == -1).all()
    for said in (
        "left out 2 points without finite coordinates",
        "merged 30 points in the same place as others",
        "left out 7 outliers, far from all other points",
    ):
        assert said in mesh.warnings


def test_stray_points_in_the_space_round_a_surface_are_left_out() -> None:
    """They are near one another, too."""
    body = shapes.icosphere(4).vertices
    around = np.random.default_rng(6).uniform(-3.0, 3.0, (80, 3))
    stray = around[np.abs(np.linalg.norm(around, axis=1) - 1.0) > 0.5]
    mesh = cloud(np.concatenate([body, stray]))
    np.testing.assert_array_equal(mesh.vertex_ids, np.arange(len(body)))
    assert f"left out {len(stray)} outliers, far from all other points" in mesh.warnings


def test_a_surface_that_is_sampled_unevenly_is_kept() -> None:
    """One half of a sphere has thirty times as many points as the other."""
    points = on_sphere(20_000)
    kept = points[(points[:, 2] > 0.0) | (np.arange(len(points)) % 30 == 0)]
    assert cloud(kept).area > 0.9 * 4.0 * np.pi


@pytest.mark.parametrize("size", [1e-3, 1e-6, 1e-16])
def test_points_far_closer_than_others_take_no_more_memory(size: float) -> None:
    """Pictures of pixels as small as they are near would have 10¹² of them."""
    mesh = cloud(np.concatenate([on_sphere(1000), size * on_sphere(1500, seed=2)]))
    assert mesh.n_vertices > 0


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (on_sphere(19), "20 points or more"),
        (np.repeat(on_sphere(10), 5, axis=0), "there are 10"),
        (np.random.default_rng(4).random((2000, 3)), "too sparse or too noisy"),
        (np.zeros((100, 3)), "there are 1"),
        (np.outer(np.linspace(3.0, 4.0, 50), [1.0, 2.0, 3.0]), "all points lie on a line"),
        (helix(200), "they lie along curves"),
        (1.0 / np.array([2.0, 3.0, 5.0]) ** np.arange(60)[:, None], "distances differ too much"),
    ],
)
def test_what_is_no_surface_is_refused(points: FloatArray, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        cloud(points)


def test_geodesics_and_spectrum_are_those_of_the_sphere() -> None:
    points = on_sphere(2000)
    shape = Shape(cloud(points), eigenpairs=10, normalise=False)
    sources = np.arange(0, 2000, 100)
    exact = np.arccos(np.clip(points[sources] @ points.T, -1.0, 1.0))
    found = shape.metric("geodesic").distances(sources)
    far = exact > 0.5
    assert np.abs(found[far] / exact[far] - 1.0).mean() < 0.02
    np.testing.assert_allclose(shape.spectrum().eigenvalues[1:9], [2.0] * 3 + [6.0] * 5, rtol=0.05)


def test_a_cloud_is_matched_with_the_mesh_it_was_sampled_from() -> None:
    directions = on_sphere(1500)
    points = shapes.with_bumps(directions)
    body = shapes.blob(3)
    target = Shape(body, eigenpairs=60)
    source = Shape(cloud(points), eigenpairs=60)
    dense = match(source, target, MatchOptions(points=12, dense=True)).dense
    assert dense is not None
    nearest = np.argmax(directions @ shapes.icosphere(3).vertices.T, axis=1)[dense.source]
    errors = target.metric("geodesic").distances(nearest)[np.arange(len(nearest)), dense.target]
    assert errors.mean() < 0.03


@pytest.mark.parametrize("seed", range(3))
def test_bodies_are_closed_and_outside_is_out_of_them(seed: int) -> None:
    """Planes that mix both sides of a hand have no right sign."""
    body = human(resolution=3000, seed=seed)
    found = cloud(body.vertices)
    assert found.n_vertices > 0.98 * len(body.vertices)
    assert found.relative_boundary < 0.2
    assert abs(found.genus) < 2.0
    right = vertex_normals(body.vertices, body.faces)[found.vertex_ids[found.faces]].sum(axis=1)
    assert ((right * face_normals(found.vertices, found.faces)).sum(axis=1) < 0.0).mean() < 0.01


def test_signs_of_a_surface_that_is_seen_from_both_sides_are_consistent() -> None:
    """No side of a wave is outside."""
    x, y = 2.0 * np.random.default_rng(8).random((2, 2000)) - 1.0
    mesh = cloud(np.stack([x, y, 0.2 * np.sin(3.0 * x)], axis=1))
    heights = face_normals(mesh.vertices, mesh.faces)[:, 2]
    assert (heights > 0.0).all() or (heights < 0.0).all()
    assert mesh.genus == 0.0


def test_the_gaps_of_a_cloud_are_no_missing_parts() -> None:
    body = human(resolution=1500)
    whole = Shape(triangle_mesh(body.vertices, body.faces))
    points = cloud(body.vertices)
    assert points.relative_boundary > 1.0
    found = match(Shape(points), whole, MatchOptions(points=16))
    assert found.overlap is None
    assert found.confidence is not None
    assert found.confidence.reasons == ()
