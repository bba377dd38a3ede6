"""Templates registered where the answer is known, and without folds where it is not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from solver.arrays import BoolArray, IntArray
from solver.control import Control
from solver.errors import Cancelled, OptionError
from solver.mesh import TriangleMesh, face_normals, surface_tree, triangle_mesh
from solver.registration import DenseCorrespondence, register
from solver.shape import Shape
from solver.templates import RegisteredTemplate, register_template, registered, surface_distance
from solver.templates.folds import Placement, relax
from synthetic import articulated
from tests.solver import shapes


def at_vertices(mesh: TriangleMesh, images: np.ndarray) -> DenseCorrespondence:
    """The map to vertices of a surface."""
    corners = mesh.faces.ravel()
    first = np.array([np.flatnonzero(corners == vertex)[0] for vertex in images])
    faces, corner = np.divmod(first, 3)
    everywhere = np.arange(len(images))
    return DenseCorrespondence(everywhere, images, mesh.faces[faces], np.eye(3)[corner])


def independently_flipped(
    found: RegisteredTemplate, template: TriangleMesh, target: TriangleMesh
) -> int:
    """Flipped triangles, counted against all triangles of the target."""
    corners = target.vertices[target.faces]
    theirs = face_normals(target.vertices, target.faces)
    ours = face_normals(found.positions, template.faces)
    flipped = 0
    for centre, normal in zip(found.positions[template.faces].mean(axis=1), ours, strict=True):
        repeated = np.tile(centre, (len(corners), 1))
        places = trimesh.triangles.closest_point(corners, repeated)  # type: ignore[no-untyped-call]
        apart = np.linalg.norm(places - centre, axis=1)
        near = apart <= apart.min() + 1e-6 * np.sqrt(target.area)
        flipped += bool(((theirs[near] @ normal) < 0.0).all())
    return flipped


def from_surface(found: RegisteredTemplate, target: TriangleMesh) -> float:
    """Greatest distance of a vertex from the target over √area."""
    tree = surface_tree(target.vertices, target.faces)
    return float(tree.distances(found.positions).max() / np.sqrt(target.area))


@pytest.mark.parametrize("change", ["moved", "scaled", "inverted", "reflected"])
def test_a_copy_is_registered_exactly(change: str) -> None:
    mesh = shapes.blob()
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    vertices, faces = mesh.vertices @ turn + [3.0, -1.0, 2.0], mesh.faces
    if change == "scaled":
        vertices = 1000.0 * vertices
    elif change == "inverted":
        faces = faces[:, ::-1]
    elif change == "reflected":
        # As formats do it: the winding of the file is that of the mirror image, inside out.
        vertices = vertices * [-1.0, 1.0, 1.0]
    target = triangle_mesh(vertices, faces)
    found = register_template(mesh, target, at_vertices(target, np.arange(mesh.n_vertices)))
    np.testing.assert_allclose(found.positions, vertices, atol=1e-9 * np.sqrt(target.area))
    assert not found.flipped.any()
    assert from_surface(found, target) < 1e-7
    assert found.reflected == (change == "reflected")


@pytest.mark.parametrize("mirrored", [False, True])
def test_opposite_winding_of_an_open_surface_is_no_reflection(mirrored: bool) -> None:
    sheet = shapes.spherical_cap(0.8, rings=8)
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    vertices = sheet.vertices * [-1.0 if mirrored else 1.0, 1.0, 1.0] @ turn
    other = triangle_mesh(vertices, sheet.faces[:, ::-1])
    found = register_template(sheet, other, at_vertices(other, np.arange(len(vertices))))
    assert found.reflected is mirrored
    np.testing.assert_allclose(found.positions, vertices, atol=1e-12)


def test_folds_are_relaxed_on_the_surface() -> None:
    """A tenth of the vertices is put where a neighbour is, so that all triangles there fold."""
    mesh = shapes.blob()
    images = np.arange(mesh.n_vertices)
    first, neighbours = mesh.neighbours
    moved = np.random.default_rng(0).choice(mesh.n_vertices, mesh.n_vertices // 10, replace=False)
    images[moved] = neighbours[first[moved] + 1]
    dense = at_vertices(mesh, images)
    found = register_template(mesh, mesh, dense)
    assert not found.flipped.any()
    assert from_surface(found, mesh) < 1e-7
    # Vertices without folds round them stay.
    areas = np.linalg.norm(face_normals(mesh.vertices[images], mesh.faces), axis=1)
    collapsed = np.unique(mesh.faces[areas < 1e-12])
    near = np.isin(mesh.faces, collapsed).any(axis=1)
    near = np.isin(mesh.faces, mesh.faces[near]).any(axis=1)
    near = np.isin(mesh.faces, mesh.faces[near]).any(axis=1)
    far = np.setdiff1d(np.arange(mesh.n_vertices), mesh.faces[near])
    np.testing.assert_allclose(found.positions[far], mesh.vertices[far], atol=1e-9)


def test_a_patch_that_is_inside_out_is_turned() -> None:
    """The inside of a patch is put into one point's fan, with its winding reversed."""
    mesh = shapes.blob()
    centre = 17
    order = np.argsort(np.linalg.norm(mesh.vertices - mesh.vertices[centre], axis=1))
    patch = order[:40]
    first, incident = mesh.incident_faces
    face = incident[first[centre]]
    a, b, c = mesh.vertices[mesh.faces[face]]
    offsets = mesh.vertices[patch] - mesh.vertices[centre]
    plane = np.linalg.svd(offsets, full_matrices=False)[2][:2]
    u, v = 0.02 * (offsets @ plane.T / np.abs(offsets).max()).T
    normal = np.cross(b - a, c - a)
    if normal @ np.cross(*plane) > 0.0:
        u = -u
    turned = np.stack([1.0 / 3.0 + u, 1.0 / 3.0 + v, 1.0 / 3.0 - u - v], axis=1)
    dense = at_vertices(mesh, np.arange(mesh.n_vertices))
    faces, weights = dense.faces.copy(), dense.barycentric.copy()
    faces[patch], weights[patch] = mesh.faces[face], turned
    folded = replace(dense, faces=faces, barycentric=weights)
    found = register_template(mesh, mesh, folded)
    assert not found.flipped.any()
    assert independently_flipped(found, mesh, mesh) == 0
    assert from_surface(found, mesh) < 1e-7
    far = order[len(order) // 2 :]
    np.testing.assert_allclose(found.positions[far], mesh.vertices[far], atol=1e-9)


def test_components_are_relaxed_apart() -> None:
    """Links lead from one component to the other, but have no triangles that could fold."""
    mesh = shapes.blob(2)
    beside = mesh.vertices + np.array([1.05 * np.ptp(mesh.vertices[:, 0]), 0.0, 0.0])
    both = triangle_mesh(
        np.concatenate([mesh.vertices, beside]),
        np.concatenate([mesh.faces, mesh.faces + mesh.n_vertices]),
    )
    assert both.components == 2
    first, neighbours = both.edge_neighbours
    owner = np.repeat(np.arange(both.n_vertices), np.diff(first))
    component = both.component_of_vertex
    assert (component[owner] == component[neighbours]).all()
    assert len(neighbours) == 2 * len(both.edges)
    # All vertices at the ends of links lie where a neighbour does.
    images, ends = np.arange(both.n_vertices), np.unique(both.links)
    images[ends] = neighbours[first[ends]]
    found = register_template(both, both, at_vertices(both, images))
    assert not found.flipped.any()
    middle = 0.5 * (mesh.vertices[:, 0].max() + beside[:, 0].min())
    assert ((found.positions[:, 0] > middle) == (component == component[-1])).all()


def test_a_bent_body_has_no_flipped_triangle() -> None:
    poses = enumerate(["standing", "walking"])
    bodies = [articulated("human", pose, 700, seed) for seed, pose in poses]
    template, target = (triangle_mesh(one.vertices, one.faces) for one in bodies)
    found = register(Shape(template), Shape(target), [], Control())
    assert found is not None
    registered = register_template(template, target, found.dense(Control()))
    assert not registered.flipped.any()
    distance = surface_distance(registered.positions, template, target)
    # Triangles of 700 vertices are chords: they leave the other surface by as much.
    assert distance.mean < 0.01
    assert distance.greatest < 0.03
    assert independently_flipped(registered, template, target) == 0
    assert not registered.reflected


def test_a_map_of_other_meshes_is_refused() -> None:
    mesh, other = shapes.blob(2), shapes.blob(3)
    dense = at_vertices(mesh, np.arange(mesh.n_vertices))
    with pytest.raises(OptionError, match="all vertices"):
        register_template(other, mesh, dense)
    elsewhere = replace(dense, faces=dense.faces + mesh.n_vertices)
    with pytest.raises(OptionError, match="all vertices"):
        register_template(mesh, mesh, elsewhere)


def test_a_cancelled_registration_ends() -> None:
    mesh = shapes.blob(2)
    dense = at_vertices(mesh, np.zeros(mesh.n_vertices, dtype=np.int64))
    with pytest.raises(Cancelled):
        register_template(mesh, mesh, dense, Control(is_cancelled=lambda: True))


def collapsed(mesh: TriangleMesh) -> DenseCorrespondence:
    """The map of one side of a mesh to one vertex, of the other side to itself."""
    images = np.arange(mesh.n_vertices)
    side = np.flatnonzero(mesh.vertices[:, 2] > 0.5 * mesh.vertices[:, 2].max())
    images[side] = side[0]
    return at_vertices(mesh, images)


def test_triangles_without_an_area_count_as_flipped() -> None:
    mesh = shapes.blob()
    dense = collapsed(mesh)
    flat = (dense.target[mesh.faces][:, :, None] == dense.target[mesh.faces][:, None]).sum(
        axis=(1, 2)
    )
    found = register_template(mesh, mesh, dense, Control().within(0.0))
    np.testing.assert_array_equal(found.flipped, flat > 3)
    np.testing.assert_allclose(found.positions, mesh.vertices[dense.target], atol=1e-9)


@pytest.mark.parametrize("looks", [2, 4, 8, 16])
def test_a_hurried_registration_is_no_worse_than_the_images(
    looks: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = shapes.blob()
    dense = collapsed(mesh)
    given = register_template(mesh, mesh, dense, Control().within(0.0)).flipped.sum()
    left = iter(range(looks))
    monkeypatch.setattr(Control, "expired", property(lambda _: next(left, None) is None))
    assert register_template(mesh, mesh, dense).flipped.sum() <= given


def test_the_clock_is_looked_at_between_blocks_that_change_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mesh = shapes.blob()
    dense, moved = collapsed(mesh), []

    def watched(placement: Placement, vertices: IntArray, *rest: Any) -> BoolArray:
        moved.append(len(vertices))
        found: BoolArray = relax(placement, vertices, *rest)
        return found

    monkeypatch.setattr(registered, "relax", watched)
    monkeypatch.setattr(registered, "_BLOCK", mesh.n_faces)
    at_once = register_template(mesh, mesh, dense)
    assert max(moved) > 100
    moved.clear()
    monkeypatch.setattr(registered, "_BLOCK", 100)
    in_blocks = register_template(mesh, mesh, dense)
    assert max(moved) == 100
    np.testing.assert_array_equal(in_blocks.positions, at_once.positions)
