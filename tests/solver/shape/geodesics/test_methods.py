"""Properties of all methods of computing geodesic distances."""

import numpy as np
import pytest

from bench.geodesics import exact_distances
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.geodesics import GEODESIC_METHODS, geodesics
from tests.solver import shapes
from tests.solver.shape.geodesics import surfaces

MEAN_ERRORS = {"graph": 0.03, "fast_marching": 0.004, "heat": 0.05}
"""On bodies whose triangles are neither large nor thin."""


@pytest.mark.parametrize("method", GEODESIC_METHODS)
@pytest.mark.parametrize("name", shapes.CONNECTED)
def test_distances(name: str, method: str) -> None:
    mesh = shapes.CONNECTED[name]()
    sources = np.array([0, mesh.n_vertices - 1, 0])
    measure = geodesics(mesh, method)
    assert measure.n_vertices == mesh.n_vertices
    found = measure.distances(sources)
    assert found.shape == (3, mesh.n_vertices)
    assert found.dtype == np.float64
    assert np.isfinite(found).all()
    assert (found >= 0.0).all()
    np.testing.assert_array_equal(found[np.arange(3), sources], 0.0)
    np.testing.assert_array_equal(found[0], found[2])
    np.testing.assert_array_equal(found[1], measure.distances(sources[1:2])[0])
    assert (np.delete(found[0], 0) > 0.0).all()


@pytest.mark.parametrize("method", GEODESIC_METHODS)
def test_error_on_a_body(method: str) -> None:
    mesh = shapes.blob()
    sources = np.arange(0, mesh.n_vertices, 80)
    exact = exact_distances(mesh, sources)
    found = geodesics(mesh, method).distances(sources)
    apart = exact > 0.0
    relative = found[apart] / exact[apart] - 1.0
    assert np.abs(relative).mean() <= MEAN_ERRORS[method]
    if method == "graph":
        assert relative.min() >= -1e-12


@pytest.mark.parametrize("method", GEODESIC_METHODS)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_and_rigid_motion(method: str, scale: float) -> None:
    mesh = shapes.blob(2)
    sources = np.array([0, 50, 100])
    here = geodesics(mesh, method).distances(sources)
    there = geodesics(shapes.moved(mesh, seed=2, scale=scale), method).distances(sources)
    np.testing.assert_allclose(there, scale * here, rtol=1e-6 if method == "heat" else 1e-9)


@pytest.mark.parametrize("method", GEODESIC_METHODS)
def test_numbering_does_not_matter(method: str) -> None:
    mesh = shapes.blob(2)
    other, where = shapes.permuted(mesh, seed=3)
    sources = np.array([0, 50, 100])
    here = geodesics(mesh, method).distances(sources)
    there = geodesics(other, method).distances(where[sources])
    tolerance = 1e-6 if method == "heat" else 1e-9
    np.testing.assert_allclose(there[:, where], here, rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("method", GEODESIC_METHODS)
def test_distances_between_components_are_no_shorter_than_straight_lines(method: str) -> None:
    mesh = shapes.two_components()
    sources = np.array([0, mesh.n_vertices - 1])
    found = geodesics(mesh, method).distances(sources)
    apart = mesh.component_of_vertex[sources][:, None] != mesh.component_of_vertex
    lines = np.linalg.norm(mesh.vertices[sources][:, None] - mesh.vertices, axis=2)
    assert np.isfinite(found).all()
    assert (found[apart] > 0.9 * lines[apart]).all()


@pytest.mark.parametrize("method", GEODESIC_METHODS)
def test_sources_out_of_range(method: str) -> None:
    measure = geodesics(shapes.cube(), method)
    assert measure.distances(np.empty(0, dtype=np.int64)).shape == (0, measure.n_vertices)
    for wrong in (-1, measure.n_vertices):
        with pytest.raises(IndexError, match=r"vertices 0\.\."):
            measure.distances(np.array([0, wrong]))


def damaged() -> TriangleMesh:
    """A fan of needles, a fin, a cone on its tip, and sheets that meet in a line."""
    cone = surfaces.cone(4, 0.2)[0]
    sphere = shapes.icosphere(2)
    squeezed = sphere.vertices * np.array([1.0, 1e-4, 1.0])
    tip, top = int(np.argmax(squeezed[:, 2])), squeezed[:, 2].max()
    faces = cone.faces + sphere.n_vertices - 1
    faces[cone.faces == 0] = tip
    fin = np.array([[*sphere.faces[0][:2], sphere.n_vertices + cone.n_vertices - 1]])
    vertices = np.concatenate(
        [squeezed, cone.vertices[1:] + np.array([0.0, 0.0, top]), [[0.0, 3.0, 0.0]]]
    )
    return triangle_mesh(vertices, np.concatenate([sphere.faces, faces, fin]))


@pytest.mark.parametrize("method", GEODESIC_METHODS)
def test_damaged_mesh(method: str) -> None:
    mesh = damaged()
    sources = np.arange(0, mesh.n_vertices, 30)
    found = geodesics(mesh, method).distances(sources)
    assert np.isfinite(found).all()
    if method == "heat":  # smooths away what is thinner than its triangles
        return
    assert (found >= 0.95 * surfaces.straight(mesh, sources)).all()
