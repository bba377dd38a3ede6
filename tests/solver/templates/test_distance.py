"""Distance between a registered template and its target, against values known otherwise."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from solver.arrays import FloatArray
from solver.control import Control
from solver.errors import Cancelled
from solver.mesh import triangle_mesh
from solver.templates import SurfaceDistance, surface_distance
from tests.solver import shapes


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_copy_has_no_distance_from_its_target(scale: float) -> None:
    mesh = shapes.blob()
    copy = triangle_mesh(scale * mesh.vertices + 10.0 * scale, mesh.faces)
    found = surface_distance(copy.vertices, mesh, copy)
    assert found.greatest < 1e-7


def test_a_template_on_half_of_a_plane_leaves_the_other_half_uncovered() -> None:
    mesh = shapes.plane_grid(width=2.0)
    squeezed = mesh.vertices * [0.5, 1.0, 1.0]
    found = surface_distance(squeezed, mesh, mesh)
    uncovered = np.maximum(mesh.vertices[:, 0] - 1.0, 0.0)
    expected = SurfaceDistance(uncovered.mean(), uncovered.max())
    assert found.mean == pytest.approx(expected.mean / np.sqrt(2.0))
    assert found.greatest == pytest.approx(expected.greatest / np.sqrt(2.0))


def test_triangles_of_a_random_map_cross_the_inside() -> None:
    """All vertices are on the target, and the target's are on the template."""
    mesh = shapes.icosphere(2)
    positions = mesh.vertices[np.random.default_rng(0).permutation(mesh.n_vertices)]
    found = surface_distance(positions, mesh, mesh)
    corners = mesh.vertices[mesh.faces]
    apart = np.array([_from_triangles(corners, one) for one in positions[mesh.faces].mean(axis=1)])
    size = np.sqrt(mesh.area)
    assert found.mean == pytest.approx(apart.mean() / size)
    assert found.greatest == pytest.approx(apart.max() / size)
    assert found.mean > 0.1


def _from_triangles(corners: FloatArray, point: FloatArray) -> float:
    repeated = np.tile(point, (len(corners), 1))
    places = trimesh.triangles.closest_point(corners, repeated)  # type: ignore[no-untyped-call]
    return float(np.linalg.norm(places - point, axis=1).min())


def test_past_the_deadline_few_points_are_measured() -> None:
    mesh = shapes.blob()
    positions = mesh.vertices * [0.5, 1.0, 1.0]
    whole = surface_distance(positions, mesh, mesh)
    hurried = surface_distance(positions, mesh, mesh, Control().within(0.0))
    assert hurried.mean == pytest.approx(whole.mean, rel=0.5)
    assert hurried.greatest <= whole.greatest
    cancelled = replace(Control(), is_cancelled=lambda: True)
    with pytest.raises(Cancelled):
        surface_distance(positions, mesh, mesh, cancelled)
