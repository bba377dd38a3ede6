"""Smooth surfaces: normals, tangents and curvatures against meshes and closed forms."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, triangle_mesh, vertex_normals
from solver.registration.curvature import CURVATURE_TIMES
from solver.registration.surface import (
    MIRROR,
    SmoothSurface,
    _gradients,
    _unit_normals,
)
from solver.shape import Shape
from solver.shape.laplacian import Spectrum
from tests.solver import shapes

RADIUS = 1.0 / np.sqrt(4.0 * np.pi)
"""Of the sphere of unit area."""


@pytest.fixture(scope="module")
def sphere() -> SmoothSurface:
    return SmoothSurface(Shape(shapes.icosphere(4)))


def flipped(mesh: TriangleMesh) -> TriangleMesh:
    """Inside out in the file, which :func:`.triangle_mesh` puts right."""
    return triangle_mesh(mesh.vertices, mesh.faces[:, ::-1])


@pytest.mark.parametrize("k", [12, 50])
def test_normals_are_those_of_the_displaced_mesh(surface: SmoothSurface, k: int) -> None:
    everywhere = surface.at(np.arange(surface.mesh.n_vertices))
    displacement = 0.02 * np.random.default_rng(0).standard_normal((k, 3)) / np.sqrt(k)
    positions, normals = everywhere.surface(surface.coefficients[:k] + displacement)
    functions = surface.spectrum.eigenfunctions[:, :k]
    np.testing.assert_allclose(positions, functions @ (surface.coefficients[:k] + displacement))
    expected = vertex_normals(positions, surface.mesh.faces)
    cosines = (normals * expected).sum(axis=1)
    assert np.median(cosines) > 0.999
    assert (cosines > 0.95).mean() > 0.99
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)


def test_unit_normals_are_those_of_numpy() -> None:
    first, second = np.random.default_rng(2).standard_normal((2, 20, 3))
    second[3] = 2.0 * first[3]  # no normal
    found = _unit_normals(first, second, -1.0)
    expected = -np.cross(first, second)
    expected /= np.maximum(np.linalg.norm(expected, axis=1, keepdims=True), 1e-12)
    np.testing.assert_allclose(found, expected, atol=1e-15)


def test_gradients_of_linear_functions_are_exact() -> None:
    mesh = shapes.plane_grid()
    chosen = np.array([0, 20, 50, 100, 175])
    slopes = np.array([[2.0, -1.0, 0.0], [0.5, 3.0, 0.0]]).T
    found = (_gradients(mesh, chosen) @ (mesh.vertices @ slopes)).reshape(5, 3, 2)
    np.testing.assert_allclose(found, np.broadcast_to(slopes, (5, 3, 2)), atol=1e-12)


def test_tangents_are_derivatives_in_the_tangent_plane_of_a_sphere(sphere: SmoothSurface) -> None:
    """The derivative of the position in a direction is that direction."""
    samples = sphere.samples
    u, v = samples.derivatives(sphere.coefficients)
    outwards = samples.positions / RADIUS
    for one, other, expected in ((u, u, 1.0), (v, v, 1.0), (u, v, 0.0)):
        np.testing.assert_allclose((one * other).sum(axis=1), expected, atol=0.03)
    for one in (u, v):
        np.testing.assert_allclose((one * outwards).sum(axis=1), 0.0, atol=0.02)
    np.testing.assert_allclose(np.cross(u, v), outwards, atol=0.05)


def test_tangents_are_difference_quotients_of_smooth_functions(sphere: SmoothSurface) -> None:
    """The derivative of f = x y on a sphere, by central differences along great circles."""
    samples, eigenfunctions = sphere.samples, sphere.spectrum.eigenfunctions

    def product(points: FloatArray) -> FloatArray:
        found: FloatArray = RADIUS**2 * points[:, 0] * points[:, 1] / (points**2).sum(axis=1)
        return found

    values = product(sphere.mesh.vertices)
    coefficients = eigenfunctions.T @ (sphere.spectrum.mass * values)
    found = samples.tangents @ coefficients
    directions = samples.derivatives(sphere.coefficients)
    step = 1e-4
    for one, derivative in zip(directions, found, strict=True):
        ends = [product(samples.positions + side * step * one) for side in (1.0, -1.0)]
        np.testing.assert_allclose(derivative, (ends[0] - ends[1]) / (2.0 * step), atol=0.01)


def test_mean_curvature_of_a_sphere(sphere: SmoothSurface) -> None:
    """1 / r, for a sphere that diffusion for time t shrinks by exp(-2 t / r²)."""
    for column, time in enumerate(CURVATURE_TIMES):
        expected = np.sqrt(time) * np.exp(-2.0 * time / RADIUS**2) / RADIUS
        np.testing.assert_allclose(sphere.samples.curvatures[:, column], expected, rtol=0.03)


@pytest.mark.parametrize("inside_out", [False, True])
def test_mean_curvature_is_positive_where_a_surface_is_convex(inside_out: bool) -> None:
    """On a torus with 2 r > R, H > 0 outside and H < 0 at the hole."""
    mesh = shapes.torus(40, 24, 1.0, 0.75)
    found = SmoothSurface(Shape(flipped(mesh) if inside_out else mesh))
    samples = found.samples
    from_axis = np.linalg.norm(mesh.vertices[samples.vertices, :2], axis=1)
    outer, inner = from_axis > 1.6, from_axis < 0.3
    assert (samples.curvatures[outer] > 0.0).all()
    assert (samples.curvatures[inner] < 0.0).all()
    averages = found.averages.at(samples.vertices)
    np.testing.assert_array_equal(averages, found.averages.at()[samples.vertices])
    assert (averages[outer] > 0.0).all()
    assert (averages[inner] < 0.0).all()


def test_the_winding_changes_neither_normals_nor_curvatures(surface: SmoothSurface) -> None:
    other = SmoothSurface(Shape(flipped(shapes.blob())))
    np.testing.assert_allclose(other.normals, surface.normals, atol=1e-12)
    np.testing.assert_allclose(other.samples.curvatures, surface.samples.curvatures, atol=1e-6)
    np.testing.assert_allclose(other.averages.at(), surface.averages.at(), atol=1e-6)
    here, there = (one.samples.smoothed(30) for one in (surface, other))
    np.testing.assert_allclose(there[1], here[1], atol=1e-6)


def test_a_reflected_surface_has_reflected_normals_and_the_same_curvatures(
    surface: SmoothSurface,
) -> None:
    samples = surface.samples
    reflected = samples.reflected()
    for here, there in zip(samples.smoothed(40), reflected.smoothed(40), strict=True):
        np.testing.assert_allclose(there, here * MIRROR, atol=1e-12)
    mesh = shapes.blob()
    mirrored = SmoothSurface(Shape(triangle_mesh(mesh.vertices * MIRROR, mesh.faces)))
    np.testing.assert_allclose(mirrored.samples.curvatures, samples.curvatures, atol=1e-6)
    twice = reflected.reflected()
    assert reflected.reflection
    assert not twice.reflection
    np.testing.assert_array_equal(twice.coefficients, samples.coefficients)


def test_fewer_samples_are_the_first_ones(surface: SmoothSurface) -> None:
    few = surface.samples.first(50)
    assert len(few) == 50
    np.testing.assert_array_equal(few.vertices, surface.samples.vertices[:50])
    for here, there in zip(few.smoothed(20), surface.samples.smoothed(20), strict=True):
        np.testing.assert_allclose(here, there[:50], atol=1e-12)
    assert len(np.unique(surface.samples.vertices)) == len(surface.samples)


def test_the_laplacian_is_the_same_from_a_stored_spectrum(surface: SmoothSurface) -> None:
    shape = Shape(shapes.blob())
    stored = Spectrum.from_bytes(shape.spectrum().to_bytes())
    again = SmoothSurface(Shape(shape.mesh, stored))
    stiffness, mass = again.laplacian
    known, known_mass = SmoothSurface(shape).laplacian
    assert abs(stiffness - known).max() == 0.0
    np.testing.assert_array_equal(mass, known_mass)


def test_neighbours_and_triangles_of_a_vertex(surface: SmoothSurface) -> None:
    faces = surface.mesh.faces
    for vertex in (0, 7, 300):
        rows = np.flatnonzero((faces == vertex).any(axis=1))
        first, incident = surface.mesh.incident_faces
        np.testing.assert_array_equal(np.sort(incident[first[vertex] : first[vertex + 1]]), rows)
        first, neighbours = surface.mesh.neighbours
        around = np.setdiff1d(faces[rows], [vertex])
        found = np.sort(neighbours[first[vertex] : first[vertex + 1]])
        np.testing.assert_array_equal(found, around)
