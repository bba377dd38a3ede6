"""Links between components: fewest and shortest connections, and what is computed over them."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.distance import cdist

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh, largest_component, triangle_mesh
from solver.mesh.edges import components_of
from solver.mesh.links import component_links
from solver.shape import Shape
from solver.shape.geodesics import GEODESIC_METHODS, geodesics
from solver.shape.laplacian import laplacian
from tests.solver import shapes


def two_spheres(gap: float = 0.4) -> TriangleMesh:
    """Two unit spheres of 162 vertices, as far apart as the gap along x."""
    sphere = shapes.icosphere(2)
    low, high = sphere.vertices[:, 0].min(), sphere.vertices[:, 0].max()
    beside = sphere.vertices + np.array([high - low + gap, 0.0, 0.0])
    return triangle_mesh(
        np.concatenate([sphere.vertices, beside]),
        np.concatenate([sphere.faces, sphere.faces + sphere.n_vertices]),
    )


def cut_in_two(mesh: TriangleMesh, gap: float) -> tuple[TriangleMesh, IntArray]:
    """Cut a mesh between its faces, and the vertex of the whole that each vertex was."""
    above = mesh.vertices[mesh.faces].mean(axis=1)[:, 2] > 0.05
    corners = np.where(above[:, None], mesh.faces + mesh.n_vertices, mesh.faces)
    raised = mesh.vertices + np.array([0.0, 0.0, gap])
    used, faces = np.unique(corners, return_inverse=True)
    vertices = np.concatenate([mesh.vertices, raised])[used]
    return triangle_mesh(vertices, faces.reshape(-1, 3)), used % mesh.n_vertices


@st.composite
def scattered(draw: st.DrawFn) -> tuple[FloatArray, IntArray, BoolArray]:
    """Points in general position, their components, none of which is empty, and those on rims."""
    count = draw(st.integers(1, 40))
    several = draw(st.integers(1, count))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    component = np.concatenate([np.arange(several), random.integers(several, size=count - several)])
    rim = random.random(count) < draw(st.sampled_from([0.0, 0.3, 1.0]))
    return random.standard_normal((count, 3)), random.permutation(component).astype(np.int64), rim


@given(scattered())
def test_links_have_the_least_total_length_that_connects(
    points: tuple[FloatArray, IntArray, BoolArray],
) -> None:
    """A minimum spanning tree of the components, of which two with rims are as far apart as these.

    By Kruskal's algorithm on all gaps.
    """
    vertices, component, rim = points
    links = component_links(vertices, component, 0.0, rim)
    count = int(component.max()) + 1
    assert components_of(component[links], count).max() == 0
    gaps = np.full((count, count), np.inf)
    between = cdist(vertices, vertices)
    is_cut = np.isin(component, component[rim])
    between[np.outer(is_cut, is_cut) & ~np.outer(rim, rim)] = np.inf
    np.minimum.at(gaps, (component[:, None], component[None]), between)
    np.fill_diagonal(gaps, 0.0)
    tree = minimum_spanning_tree(gaps)
    assert len(links) == count - 1
    assert between[links[:, 0], links[:, 1]].sum() == pytest.approx(tree.sum())


def test_neighbours_over_edges_are_found_without_links() -> None:
    """Links of many components take time."""
    mesh = two_spheres()
    first, neighbours = mesh.edge_neighbours
    assert "links" not in vars(mesh)
    ends = mesh.component_of_vertex[neighbours]
    own = np.repeat(mesh.component_of_vertex, np.diff(first))
    np.testing.assert_array_equal(ends, own)


def test_a_connected_mesh_has_no_links() -> None:
    assert shapes.blob().links.shape == (0, 2)


def test_a_cut_is_linked_along_the_whole_of_its_rim() -> None:
    cut, was = cut_in_two(shapes.blob(), 0.01)
    assert cut.components == 2
    apart = was[cut.links]
    np.testing.assert_array_equal(apart[:, 0], apart[:, 1])
    assert len(cut.links) == cut.n_vertices - shapes.blob().n_vertices


def test_what_is_cut_is_linked_from_rim_to_rim_even_if_it_touches_elsewhere() -> None:
    cap = shapes.spherical_cap(0.5, rings=12)
    bowl = cap.vertices - cap.vertices[cap.vertices[:, 2].argmax()]
    # Two bowls that stand on one another: what is nearest is in the middle of each.
    facing = bowl * np.array([1.0, 1.0, -1.0]) + np.array([0.0, 0.0, 0.01])
    both = triangle_mesh(
        np.concatenate([bowl, facing]),
        np.concatenate([cap.faces, cap.faces[:, ::-1] + cap.n_vertices]),
    )
    here, there = both.links.T
    np.testing.assert_array_equal(here, np.flatnonzero(cap.on_boundary))
    np.testing.assert_array_equal(there, here + cap.n_vertices)


def test_links_have_no_area() -> None:
    both = two_spheres()
    assert both.area == pytest.approx(2.0 * shapes.icosphere(2).area)
    assert laplacian(both)[1].sum() == pytest.approx(both.area)
    assert both.n_faces == 2 * shapes.icosphere(2).n_faces


@pytest.mark.parametrize("method", GEODESIC_METHODS)
def test_geodesics_lead_over_the_gap_by_the_links(method: str) -> None:
    both = two_spheres()
    distances = geodesics(both, method).distances(np.arange(both.n_vertices))
    left = both.component_of_vertex == both.component_of_vertex[0]
    here, there = np.where(left[both.links[:, :1]], both.links, both.links[:, ::-1]).T
    assert left[here].all()
    assert not left[there].any()
    # To a link on one sphere, over it, and on over the other sphere.
    gaps = np.linalg.norm(both.vertices[here] - both.vertices[there], axis=1)
    ways = distances[left][:, here, None] + gaps[:, None] + distances[there][:, ~left]
    relative = distances[left][:, ~left] / ways.min(axis=1) - 1.0
    # Fronts from several links meet, and heat knows bridges of triangles instead of links.
    allowed = {"graph": 1e-9, "fast_marching": 0.02, "heat": 0.15}
    assert np.abs(relative).mean() < allowed[method]


def test_distances_over_a_narrow_cut_are_those_of_the_whole() -> None:
    whole = shapes.blob()
    cut, was = cut_in_two(whole, 0.01)
    sources = np.arange(0, cut.n_vertices, 40)
    expected = geodesics(whole).distances(was[sources])[:, was]
    found = geodesics(cut).distances(sources)
    far = expected > 0.5
    assert np.abs(found[far] / expected[far] - 1.0).mean() < 0.02


@pytest.mark.parametrize("make", [two_spheres, shapes.two_components])
def test_only_constants_have_eigenvalue_zero(make: Callable[[], TriangleMesh]) -> None:
    stiffness, _ = laplacian(make())
    eigenvalues, functions = np.linalg.eigh(stiffness.toarray())
    assert abs(eigenvalues[0]) < 1e-9
    assert eigenvalues[1] > 1e-4
    assert np.ptp(functions[:, 0]) < 1e-9
    # Without links there is a constant of each component.
    apart = np.linalg.eigvalsh(laplacian(make(), linked=False)[0].toarray())
    assert np.abs(apart[:2]).max() < 1e-9


def test_the_spectrum_of_a_cut_surface_is_nearly_that_of_the_whole() -> None:
    whole, (cut, _) = shapes.blob(), cut_in_two(shapes.blob(), 0.01)
    expected = Shape(whole, eigenpairs=12).spectrum().eigenvalues[1:]
    found = Shape(cut, eigenpairs=12).spectrum().eigenvalues[1:]
    np.testing.assert_allclose(found, expected, rtol=0.1)


def test_a_body_cut_in_two_is_matched_with_the_whole() -> None:
    whole, (cut, was) = shapes.blob(2), cut_in_two(shapes.blob(2), 0.03)
    other, where = shapes.permuted(shapes.moved(whole, seed=3), seed=4)
    target = Shape(other, eigenpairs=60)
    dense = match(Shape(cut, eigenpairs=60), target, MatchOptions(points=12, dense=True)).dense
    assert dense is not None
    np.testing.assert_array_equal(np.sort(dense.source), np.arange(cut.n_vertices))
    truth = where[was[dense.source]]
    errors = target.metric("geodesic").distances(truth)[np.arange(len(truth)), dense.target]
    assert errors.mean() < 0.02


def test_only_the_whole_says_that_it_is_linked() -> None:
    both = two_spheres()
    assert "2 components are linked" in both.warnings[-1]
    assert "50 % of the area" in both.warnings[-1]
    assert largest_component(both).components == 1
    assert not any("linked" in warning for warning in largest_component(both).warnings)
