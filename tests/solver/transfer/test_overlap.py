"""Overlap along a map: areas, values of faces, and what there and back loses."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from solver.arrays import IntArray
from solver.errors import TransferError
from solver.mesh import TriangleMesh, largest_component, read_mesh, triangle_areas, triangle_mesh
from solver.registration import DenseCorrespondence
from solver.transfer import (
    FACES,
    LABELS,
    SCALARS,
    VERTICES,
    Attribute,
    Overlap,
    carried,
    overlap_of,
)
from tests.solver import shapes
from tests.solver.mesh import mesh_files
from tests.solver.transfer.maps import registered

MESH = triangle_mesh(shapes.blob(3).vertices, shapes.blob(3).faces)
OTHER, WHERE = shapes.permuted(MESH, seed=5)
FINER = triangle_mesh(shapes.blob(4).vertices, shapes.blob(4).faces)
SEEDS = st.integers(0, 2**31 - 1)


def identity(mesh: TriangleMesh) -> DenseCorrespondence:
    """The map of a surface to itself: each vertex is a corner of one of its triangles."""
    first, incident = mesh.incident_faces
    corners = mesh.vertex_ids[mesh.faces[incident[first[:-1]]]]
    shares = (corners == mesh.vertex_ids[:, None]).astype(np.float64)
    order = np.argsort(mesh.vertex_ids)
    ids = mesh.vertex_ids[order]
    return DenseCorrespondence(ids, ids, corners[order], shares[order])


def areas(mesh: TriangleMesh) -> np.ndarray:
    return triangle_areas(mesh.vertices, mesh.faces)


def parts(mesh: TriangleMesh, count: int = 6) -> IntArray:
    """(F,) sectors round the z axis: labels of faces by their centres."""
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    angle = np.arctan2(centre[:, 1], centre[:, 0]) / (2.0 * np.pi) + 0.5
    found: IntArray = np.minimum((angle * count).astype(np.int64), count - 1)
    return found


def agreement(mesh: TriangleMesh, found: np.ndarray, expected: np.ndarray) -> float:
    """Share of the area whose label is the expected one."""
    return float(areas(mesh)[found == expected].sum() / mesh.area)


@pytest.mark.parametrize("of", [VERTICES, FACES])
@pytest.mark.parametrize("onto", [VERTICES, FACES])
def test_areas_sum_to_those_of_the_faces_and_of_the_cells(onto: str, of: str) -> None:
    table = overlap_of(MESH, identity(MESH), MESH, onto, of).areas
    rows = areas(MESH)
    if onto == VERTICES:
        rows = np.bincount(MESH.faces.ravel(), np.repeat(rows / 3.0, 3))
    np.testing.assert_allclose(table.sum(axis=1), rows, rtol=1e-9)
    assert table.shape == (
        MESH.n_faces if onto == FACES else MESH.n_vertices,
        MESH.n_faces if of == FACES else MESH.n_vertices,
    )


def test_the_identity_maps_faces_to_themselves() -> None:
    found = overlap_of(MESH, identity(MESH), MESH, FACES, FACES)
    every = np.arange(MESH.n_faces)
    np.testing.assert_array_equal(found.majority(every), every)
    assert found.areas.diagonal().sum() > 0.99 * MESH.area


def test_linear_functions_of_vertices_have_their_means_over_faces() -> None:
    grid = shapes.plane_grid()
    height = grid.vertices @ np.array([0.3, -1.0, 0.7])
    found = overlap_of(grid, identity(grid), grid, FACES, VERTICES).means(height)
    np.testing.assert_allclose(found, height[grid.faces].mean(axis=1), atol=1e-12)


@given(SEEDS)
def test_majority_and_means_are_those_of_the_table(seed: int) -> None:
    random = np.random.default_rng(seed)
    table = random.random((9, 30)) * (random.random((9, 30)) < 0.3)
    table[4] = 0.0
    along = Overlap(sp.csr_array(table))
    labels = np.array(["head", "arm", "leg"])[random.integers(0, 3, size=30)]
    values = random.standard_normal((30, 2))
    rows = np.flatnonzero(table.sum(axis=1))
    shares = np.stack([table[:, labels == one].sum(axis=1) for one in np.unique(labels)], axis=1)
    expected = np.unique(labels)[shares.argmax(axis=1)]
    np.testing.assert_array_equal(along.majority(labels), expected[rows])
    means = (table @ values)[rows] / table.sum(axis=1)[rows, None]
    np.testing.assert_allclose(along.means(values), means)
    spread = along.spread(along.majority(labels), "")
    assert spread[4] == ""
    assert len(spread) == 9
    with pytest.raises(TransferError, match="there are 29 rows of values, and 30 are needed"):
        along.majority(labels[:29])


@pytest.mark.parametrize("target", [OTHER, FINER], ids=["permuted", "finer"])
def test_labels_of_faces_there_and_back(target: TriangleMesh) -> None:
    there = registered(MESH, target)
    assert there.inverse is not None
    labels = Attribute("part", parts(MESH), on=FACES)
    forth = carried(
        labels, LABELS, overlap_of(target, there.inverse, MESH, FACES, FACES), onto=FACES
    )
    assert (forth.on, len(forth.values)) == (FACES, target.n_faces)
    assert agreement(target, forth.values, parts(target)) > 0.97
    back = carried(forth, LABELS, overlap_of(MESH, there, target, FACES, FACES), onto=FACES)
    assert agreement(MESH, back.values, labels.values) > 0.99


def test_labels_of_faces_onto_vertices_and_back() -> None:
    there = registered(MESH, FINER)
    assert there.inverse is not None
    labels = Attribute("part", parts(MESH), on=FACES)
    onto = carried(labels, LABELS, overlap_of(FINER, there.inverse, MESH, VERTICES, FACES))
    assert (onto.on, len(onto.values)) == (VERTICES, FINER.n_vertices)
    back = carried(onto, LABELS, overlap_of(MESH, there, FINER, FACES, VERTICES), onto=FACES)
    assert agreement(MESH, back.values, labels.values) > 0.97


def test_scalars_of_faces_keep_their_integral() -> None:
    there = registered(MESH, OTHER)
    assert there.inverse is not None
    density = Attribute("density", 2.0 + MESH.vertices[MESH.faces].mean(axis=1)[:, 2], on=FACES)
    along = overlap_of(OTHER, there.inverse, MESH, FACES, FACES)
    found = carried(density, SCALARS, along, onto=FACES).values
    before, after = density.values @ areas(MESH), found @ areas(OTHER)
    assert after / OTHER.area == pytest.approx(before / MESH.area, rel=2e-3)
    values = density.values.copy()
    values[3] = np.inf
    with pytest.raises(TransferError, match="'density' of face 3 is infinite"):
        carried(Attribute("density", values, on=FACES), SCALARS, along, onto=FACES)


def test_rows_are_those_of_polygons_and_of_damaged_files() -> None:
    """A cube of squares, with a face without area first, and a vertex that no face uses."""
    corners = [[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = [[0, 0, 1], [0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]]
    cube = read_mesh(mesh_files.ply(np.array([*corners, [5.0, 5, 5]]), faces), "ply")
    along = overlap_of(cube, identity(cube), cube, FACES, FACES)
    assert along.areas.shape == (6, 6)
    assert along.areas.sum() == pytest.approx(5.0)
    labels = Attribute("side", np.array(["none", "a", "b", "c", "d", "e"]), on=FACES)
    found = carried(labels, LABELS, along, onto=FACES)
    assert found.values.tolist() == ["", "a", "b", "c", "d", "e"]
    onto = carried(labels, LABELS, overlap_of(cube, identity(cube), cube, VERTICES, FACES))
    assert onto.values[8] == ""
    assert set(onto.values[:8]) <= set("abcde")


def test_vertices_that_were_merged_have_the_values_of_those_they_were_merged_into() -> None:
    """Loose triangles: each vertex of the file is a corner of one face."""
    blob = shapes.blob(2)
    loose = blob.vertices[blob.faces].reshape(-1, 3)
    mesh = triangle_mesh(loose, np.arange(len(loose)).reshape(-1, 3))
    found = overlap_of(mesh, identity(mesh), mesh, VERTICES, FACES).majority(parts(mesh))
    assert len(found) == len(loose)
    of_vertex = np.full(blob.n_vertices, -1)
    of_vertex[blob.faces.ravel()] = found
    np.testing.assert_array_equal(of_vertex[blob.faces.ravel()], found)


def test_faces_that_are_not_mapped_are_left_out() -> None:
    both = triangle_mesh(shapes.two_components().vertices, shapes.two_components().faces)
    part = largest_component(both)
    assert part.face_ids is not None
    found = overlap_of(both, identity(part), part, FACES, FACES)
    covered = np.flatnonzero(found.areas.sum(axis=1))
    np.testing.assert_array_equal(covered, np.sort(part.face_ids))


def test_a_shape_of_unknown_faces_is_refused() -> None:
    plain = TriangleMesh(MESH.vertices, MESH.faces, MESH.vertex_ids)
    with pytest.raises(TransferError, match="faces of the shape's file are not known"):
        overlap_of(plain, identity(plain), plain, FACES, VERTICES)
    table = overlap_of(plain, identity(plain), plain, VERTICES, VERTICES).areas
    assert table.shape == (MESH.n_vertices, MESH.n_vertices)
