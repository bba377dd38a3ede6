"""Simplification: the vertices left are the user's own, and the surface is what it was."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial import KDTree

from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh, simplified, triangle_mesh
from solver.mesh.edges import edges_of
from solver.shape import Shape
from tests.solver import shapes
from tests.solver.mesh.repair.damage import Damage, distorting, read, seams


def euler_characteristic(mesh: TriangleMesh) -> int:
    return mesh.n_vertices - len(mesh.edges) + mesh.n_faces


def crowded_edges(mesh: TriangleMesh) -> int:
    return int((edges_of(mesh.faces).counts > 2).sum())


FINE = {
    "icosphere": (shapes.icosphere, 162),
    "blob": (shapes.blob, 100),
    "torus": (shapes.torus, 90),
    "cube": (shapes.cube, 60),
    "plane_grid": (shapes.plane_grid, 30),
    "tube": (shapes.tube, 500),
    "moebius_strip": (shapes.moebius_strip, 60),
    "three_sheets": (shapes.three_sheets, 20),
}


@pytest.mark.parametrize("name", FINE)
def test_the_topology_is_kept_and_vertices_stay_in_their_places(name: str) -> None:
    make, count = FINE[name]
    mesh = shapes.permuted(make(), seed=1)[0]
    coarse = simplified(mesh, count)
    assert coarse.n_vertices == count
    np.testing.assert_array_equal(coarse.vertices, mesh.vertices[coarse.vertex_ids])
    assert len(np.unique(coarse.vertex_ids)) == count
    assert euler_characteristic(coarse) == euler_characteristic(mesh)
    assert (coarse.closed, coarse.components) == (mesh.closed, mesh.components)
    assert crowded_edges(coarse) == crowded_edges(mesh)
    # Sound without any repair, and oriented as before.
    again = triangle_mesh(coarse.vertices, coarse.faces)
    np.testing.assert_array_equal(again.faces, coarse.faces)
    assert f"simplified from {mesh.n_vertices} to {count} vertices" in coarse.warnings[-1]
    assert "a dense map, and what is carried along it" in coarse.warnings[-1]


def test_every_vertex_is_stood_for_by_one_near_it() -> None:
    mesh = shapes.blob(4)
    coarse = simplified(mesh, 300)
    heirs = coarse.vertices_of(np.arange(mesh.n_vertices))
    assert heirs.min() >= 0
    np.testing.assert_array_equal(heirs[coarse.vertex_ids], np.arange(300))
    apart = np.linalg.norm(coarse.vertices[heirs] - mesh.vertices, axis=1)
    nearest = np.asarray(KDTree(coarse.vertices).query(mesh.vertices)[0])
    assert apart.max() < 3.0 * nearest.max()


def test_distances_and_spectrum_are_nearly_the_same() -> None:
    mesh = shapes.blob(4)
    coarse = simplified(mesh, 640)
    fine, few = Shape(mesh, eigenpairs=16), Shape(coarse, eigenpairs=16)
    assert coarse.area == pytest.approx(mesh.area, rel=0.01)
    eigenvalues = few.spectrum().eigenvalues[1:] / fine.spectrum().eigenvalues[1:]
    np.testing.assert_allclose(eigenvalues, 1.0, atol=0.02)
    points = np.arange(0, 640, 16)
    truth = fine.metric("geodesic").between(coarse.vertex_ids[points])
    error = np.abs(few.metric("geodesic").between(points) - truth)
    assert error.mean() < 0.015
    assert error.max() < 0.06


def test_flat_faces_and_straight_boundaries_lose_nothing() -> None:
    for make, count in ((shapes.plane_grid, 20), (shapes.cube, 50)):
        mesh = make()
        coarse = simplified(mesh, count)
        assert coarse.area == pytest.approx(mesh.area, rel=1e-9)
        np.testing.assert_allclose(
            [coarse.vertices.min(axis=0), coarse.vertices.max(axis=0)],
            [mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)],
        )


def test_size_and_place_do_not_matter() -> None:
    mesh = shapes.blob(3)
    expected = simplified(mesh, 200).vertex_ids
    for factor in (1e-30, 1e30):
        scaled = triangle_mesh(mesh.vertices * factor, mesh.faces)
        np.testing.assert_array_equal(simplified(scaled, 200).vertex_ids, expected)


def test_a_mesh_of_few_vertices_is_itself() -> None:
    mesh = shapes.blob(2)
    assert simplified(mesh, mesh.n_vertices) is mesh
    # There is nothing simpler than a tetrahedron.
    assert simplified(shapes.blob(2), 1).n_vertices == 4


def test_names_of_merged_vertices_still_lead_somewhere() -> None:
    damaged = seams.loose_faces(shapes.blob(3))
    coarse = simplified(read(damaged), 100)
    numbers = np.array(damaged.faces).reshape(-1)
    heirs = coarse.vertices_of(numbers)
    assert heirs.min() >= 0
    places = damaged.vertices[numbers]
    kept = coarse.vertices_of(damaged.where) >= 0
    assert kept.all()
    assert np.linalg.norm(coarse.vertices[heirs] - places, axis=1).max() < 0.8


def test_a_vertex_of_countless_faces_takes_no_time() -> None:
    n = 30_000
    angles = 2.0 * np.pi * np.arange(n) / n
    rim = np.stack([np.cos(angles), np.sin(angles), 0.2 * np.cos(5 * angles)], axis=1)
    faces = np.stack([np.arange(n), (np.arange(n) + 1) % n, np.full(n, n)], axis=1)
    fan = triangle_mesh(np.concatenate([rim, [[0.0, 0.0, 1.0]]]), faces)
    assert simplified(fan, 100).n_vertices == 100


def test_matches_on_simplified_shapes_name_the_users_vertices() -> None:
    mesh = shapes.blob(4)
    other, where = shapes.permuted(shapes.moved(mesh, 4), seed=8)
    found = match(
        Shape(simplified(mesh, 400), eigenpairs=40),
        Shape(simplified(other, 400), eigenpairs=40),
        MatchOptions(points=16),
    ).best
    distances = Shape(other).metric("geodesic").distances(where[found.source])
    errors = distances[np.arange(16), found.target]
    assert errors.mean() < 0.06


@pytest.mark.parametrize(
    "cause", [distorting.a_fin, distorting.glued_points, distorting.an_interior_wall]
)
def test_where_the_surface_is_no_manifold_it_stays(cause: Damage) -> None:
    mesh = read(cause(shapes.blob(3)))
    coarse = simplified(mesh, 150)
    assert coarse.n_vertices == 150
    assert crowded_edges(coarse) == crowded_edges(mesh)
    assert euler_characteristic(coarse) == euler_characteristic(mesh)


@st.composite
def torn(draw: st.DrawFn) -> TriangleMesh:
    """A grid or a sphere that lost some of its faces: hanging triangles, pinched vertices."""
    whole = draw(
        st.sampled_from([shapes.plane_grid(9, 7), shapes.icosphere(1), shapes.torus(8, 6)])
    )
    kept = draw(st.lists(st.booleans(), min_size=whole.n_faces, max_size=whole.n_faces))
    faces = whole.faces[np.array(kept)]
    assume(len(faces) > 0)
    return triangle_mesh(whole.vertices, faces)


@given(torn(), st.integers(1, 40))
def test_nothing_is_disconnected_and_nothing_is_lost(mesh: TriangleMesh, count: int) -> None:
    coarse = simplified(mesh, count)
    heirs = coarse.vertices_of(mesh.vertex_ids)
    assert heirs.min() >= 0
    assert coarse.components == mesh.components
    # Each component of what is left stands for one of the whole.
    pairs = np.stack([mesh.component_of_vertex, coarse.component_of_vertex[heirs]], axis=1)
    assert len(np.unique(pairs, axis=0)) == mesh.components


def test_a_triangle_that_connects_two_surfaces_stays() -> None:
    """It hangs at single vertices: its third corner and two of its sides belong to it alone."""
    grid = shapes.plane_grid(12, 8)
    right = grid.vertices + np.array([2.0, 0.0, 0.0])
    corner = 11
    tip = np.array([[1.75, 0.4, 0.0]])
    bridge = np.array([[corner, grid.n_vertices, 2 * grid.n_vertices]])
    mesh = triangle_mesh(
        np.concatenate([grid.vertices, right, tip]),
        np.concatenate([grid.faces, grid.faces + grid.n_vertices, bridge]),
    )
    coarse = simplified(mesh, 1)
    assert mesh.components == coarse.components == 1
