"""Non-manifold edges and vertices: found whatever the number of faces at them."""

import numpy as np

from solver.mesh.edges import edges_of, non_manifold_vertices
from tests.solver import shapes


def test_manifolds_have_no_non_manifold_vertices() -> None:
    for mesh in (shapes.icosphere(), shapes.plane_grid(), shapes.moebius_strip()):
        assert not len(non_manifold_vertices(mesh.faces, edges_of(mesh.faces)))


def test_two_solids_that_share_a_vertex() -> None:
    tetrahedron = shapes.tetrahedron().faces
    other = tetrahedron + 4
    other[other == 4] = 0
    faces = np.concatenate([tetrahedron, other])
    assert non_manifold_vertices(faces, edges_of(faces)).tolist() == [0]


def test_sheets_along_an_edge_are_connected_over_it() -> None:
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    edges = edges_of(faces)
    assert edges.ends[edges.counts > 2].tolist() == [[0, 1]]
    assert not len(non_manifold_vertices(faces, edges))
