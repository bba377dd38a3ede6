"""Photometric descriptors: means of known colour fields."""

from dataclasses import replace

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, simplified, triangle_mesh
from solver.shape import GeodesicMetric
from solver.shape.descriptors import photometric
from solver.shape.geodesics import GeodesicGraph
from synthetic import articulated, clothed
from tests.solver import shapes
from tests.solver.shape.descriptors.exact_distances import GreatCircles, straight_lines


def graph(mesh: TriangleMesh) -> GeodesicMetric:
    return GeodesicMetric(GeodesicGraph(mesh))


def everywhere(mesh: TriangleMesh, radius: float) -> FloatArray:
    return photometric(mesh, graph(mesh), radius, np.arange(mesh.n_vertices))


def painted(mesh: TriangleMesh, colors: FloatArray) -> TriangleMesh:
    return triangle_mesh(mesh.vertices, mesh.faces, colors)


def colorful(mesh: TriangleMesh) -> TriangleMesh:
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return painted(mesh, 0.5 + 0.5 * np.sin(9.0 * (mesh.vertices - low) / (high - low).max()))


def test_a_linear_colour_is_its_own_mean() -> None:
    """Inside; at the rim only one side counts."""
    plane = shapes.disc(60)
    x, y = plane.vertices[:, 0], plane.vertices[:, 1]
    mesh = painted(plane, np.stack([0.5 + 0.4 * x, 0.5 - 0.3 * y, 0.4 + 0.1 * (x + y)], axis=1))
    inside = np.flatnonzero(np.hypot(x, y) < 0.7)[::17]
    found = photometric(mesh, straight_lines(mesh), 0.25, inside) * np.sqrt(3.0)
    assert mesh.colors is not None
    np.testing.assert_allclose(found, mesh.colors[inside], atol=2e-4)
    east = np.array([int(np.argmax(x))])
    assert photometric(mesh, straight_lines(mesh), 0.25, east)[0, 0] * np.sqrt(3.0) < 0.87


def test_means_over_caps_of_the_sphere() -> None:
    """The mean of z over the cap of angle a around the pole is (1 + cos a) / 2."""
    sphere = shapes.icosphere(5)
    mesh = painted(sphere, 0.5 + 0.5 * sphere.vertices)
    pole = np.array([int(np.argmax(sphere.vertices[:, 2]))])
    for angle in (0.1, 0.5, 1.5, 3.0):
        found = photometric(mesh, GreatCircles(mesh), angle, pole)[0] * np.sqrt(3.0)
        direction = (1.0 + np.cos(angle)) / 2.0 * sphere.vertices[pole[0]]
        np.testing.assert_allclose(found, 0.5 + 0.5 * direction, atol=2e-3)


def test_a_constant_colour_is_its_own_mean() -> None:
    mesh = painted(shapes.blob(), np.tile([0.2, 0.7, 1.0], (len(shapes.blob().vertices), 1)))
    for radius in (0.0, 0.05, 0.5, 5.0):
        found = photometric(mesh, graph(mesh), radius, np.arange(0, mesh.n_vertices, 50))
        np.testing.assert_allclose(found * np.sqrt(3.0), np.tile([0.2, 0.7, 1.0], (len(found), 1)))


def test_another_triangulation_has_the_same_means() -> None:
    """Points of a sphere in two triangulations, one of them irregular."""
    fine = shapes.icosphere(5)
    coarse = simplified(fine, 6000)
    found = []
    for sphere in (fine, coarse):
        mesh = painted(sphere, 0.5 + 0.5 * np.sin(4.0 * sphere.vertices))
        at = np.flatnonzero(np.isin(sphere.vertex_ids, coarse.vertex_ids[::60]))
        found.append(photometric(mesh, GreatCircles(mesh), 0.3, at))
    np.testing.assert_allclose(found[0], found[1], atol=3e-3)
    assert found[0].std(axis=0).min() > 0.1


def test_a_pose_changes_little() -> None:
    poses = [articulated("human", pose, 800, 0) for pose in ("standing", "walking")]
    meshes = [triangle_mesh(one.vertices, one.faces, clothed(one.rest)) for one in poses]
    before, after = (everywhere(mesh, 0.1 * np.sqrt(mesh.area)) for mesh in meshes)
    change = np.linalg.norm(after - before, axis=1)
    spread = np.linalg.norm(before - before.mean(axis=0), axis=1)
    assert np.sqrt((change**2).mean()) < 0.1 * np.sqrt((spread**2).mean())


def test_from_one_point_to_the_whole_surface() -> None:
    mesh = colorful(shapes.blob())
    assert mesh.colors is not None
    pointwise = everywhere(mesh, 0.0)
    np.testing.assert_array_equal(pointwise, mesh.colors / np.sqrt(3.0))
    some = np.array([5, 77, 400])
    for radius in (1e-200, 1e-7):
        found = photometric(mesh, graph(mesh), radius, some)
        np.testing.assert_allclose(found, pointwise[some], atol=1e-6)
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    mean = areas @ mesh.colors[mesh.faces].mean(axis=1) / areas.sum() / np.sqrt(3.0)
    found = photometric(mesh, graph(mesh), 1e3, some)
    np.testing.assert_allclose(found, np.tile(mean, (3, 1)), rtol=1e-9)


@pytest.mark.parametrize("radius", [0.0, 0.4])
def test_invariances(radius: float) -> None:
    mesh = colorful(shapes.blob())
    found = everywhere(mesh, radius)
    assert found.shape == (mesh.n_vertices, 3)
    for scale in (1.0, 100.0):
        moved = replace(shapes.moved(mesh, seed=6, scale=scale), colors=mesh.colors)
        other = everywhere(moved, scale * radius)
        np.testing.assert_allclose(other, found, atol=1e-9)
    renumbered, where = shapes.permuted(mesh, seed=7)
    assert mesh.colors is not None
    colors = np.empty_like(mesh.colors)
    colors[where] = mesh.colors
    renumbered = replace(renumbered, colors=colors)
    other = everywhere(renumbered, radius)[where]
    np.testing.assert_allclose(other, found, atol=1e-9)
    some = np.array([3, 1, 40])
    other = photometric(mesh, graph(mesh), radius, some)
    np.testing.assert_allclose(other, found[some], rtol=1e-12)


def test_gluing_changes_means_and_no_point() -> None:
    """The second footnote of Table 1: two sheets, one on the other, joined at a corner."""
    sheet = shapes.plane_grid(9, 9, 1.0)
    above = sheet.vertices + np.array([0.0, 0.0, 1e-3])
    red, blue = np.tile([1.0, 0.0, 0.0], (81, 1)), np.tile([0.0, 0.0, 1.0], (81, 1))
    faces = np.concatenate([sheet.faces, sheet.faces + 81])
    vertices, colors = np.concatenate([sheet.vertices, above]), np.concatenate([red, blue])
    apart = triangle_mesh(sheet.vertices, sheet.faces, red)
    glued = triangle_mesh(vertices, np.concatenate([faces, [[0, 81, 1], [1, 81, 82]]]), colors)
    point = np.array([0])
    for radius, change in ((0.0, 0.0), (0.2, 0.5)):
        before = photometric(apart, graph(apart), radius, point)
        after = photometric(glued, graph(glued), radius, point)
        assert np.abs(after - before).max() * np.sqrt(3.0) == pytest.approx(change, abs=0.1)
