"""Surfaces opened where parts of them touch."""

import numpy as np
import pytest

from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration.opening import (
    CREASES,
    Crease,
    Opening,
    VertexMaps,
    _torn_open,
    creases,
    tears,
    torn_length,
    torn_off,
)
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from tests.solver import shapes

AROUND = 120


def two_balls(apart: float) -> TriangleMesh:
    """Surface round two unit balls whose centres are 2 `apart` from one another.

    At their crease normals turn by the angle α, sin(α / 2) = `apart`.
    """
    angle = np.linspace(0.0, np.arccos(-apart), 60)[1:]
    half = np.stack([apart + np.cos(angle), np.sin(angle)], axis=1)
    profile = np.concatenate([half, half[-2::-1] * [-1.0, 1.0]])
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    rings = np.stack(
        [
            np.repeat(profile[:, 0], AROUND),
            np.outer(profile[:, 1], np.cos(turn)).ravel(),
            np.outer(profile[:, 1], np.sin(turn)).ravel(),
        ],
        axis=1,
    )
    first, around = np.arange(len(profile) - 1)[:, None] * AROUND, np.arange(AROUND)
    a, b = first + around, first + (around + 1) % AROUND
    quads = np.stack([a, b, b + AROUND, a + AROUND], axis=-1).reshape(-1, 4)
    last = len(rings)
    ends = [np.stack([np.full(AROUND, last), (around + 1) % AROUND, around], axis=1)]
    below = (len(profile) - 1) * AROUND
    ends.append(
        np.stack([np.full(AROUND, last + 1), below + around, below + (around + 1) % AROUND], axis=1)
    )
    poles = np.array([[1.0 + apart, 0.0, 0.0], [-1.0 - apart, 0.0, 0.0]])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], *ends])
    return triangle_mesh(np.concatenate([rings, poles]), faces)


@pytest.mark.parametrize("crease", CREASES)
@pytest.mark.parametrize(("ratio", "creased"), [(2 / 3, False), (7 / 3, True)])
def test_a_crease_is_where_normals_turn_inwards_by_the_angle(
    crease: Crease, ratio: float, creased: bool
) -> None:
    """And by somewhat more, as the balls beside it curve the other way."""
    mesh = two_balls(ratio * crease.folded)
    found = creases(smooth_surface(Shape(mesh)), crease)
    middles = np.abs(mesh.vertices[mesh.faces, 0]).min(axis=1)
    assert found.any() == creased
    assert not found[middles > 0.15].any()
    if creased:
        assert found[middles < 1e-9].all()


def test_winding_does_not_matter_at_creases() -> None:
    mesh = two_balls(0.8)
    flipped = triangle_mesh(mesh.vertices, mesh.faces[:, ::-1])
    surfaces = (smooth_surface(Shape(one)) for one in (mesh, flipped))
    direct, turned = (creases(one, CREASES[0]) for one in surfaces)
    assert direct.any()
    np.testing.assert_array_equal(direct, turned)


def test_convex_edges_are_no_creases() -> None:
    surface = smooth_surface(Shape(shapes.cube(12)))
    assert not any(creases(surface, crease).any() for crease in CREASES)


def test_two_balls_are_opened_at_their_crease() -> None:
    """The lesser part is not too small to matter: both are left, of half the area each."""
    shape = Shape(two_balls(0.7))
    opening = Opening.at(shape, creases(smooth_surface(shape), CREASES[0]))
    left = opening.shape.mesh
    assert left.components == 2
    assert left.area > 0.9 * shape.mesh.area
    np.testing.assert_array_equal(left.vertices, shape.mesh.vertices[opening.vertices])
    np.testing.assert_array_equal(opening.vertices[left.faces], shape.mesh.faces[opening.faces])


def test_vertices_that_are_left_keep_their_places_and_others_take_the_nearest() -> None:
    shape = Shape(shapes.plane_grid(31, 21))
    out = (shape.mesh.vertices[shape.mesh.faces, 0] > 1.4).any(axis=1)
    opening = Opening.at(shape, out)
    kept = opening.vertices
    np.testing.assert_array_equal(opening.index_of_vertex[kept], np.arange(len(kept)))
    gone = np.setdiff1d(np.arange(shape.n_vertices), kept)
    assert len(gone)
    apart = shape.mesh.vertices[kept[opening.index_of_vertex[gone]]] - shape.mesh.vertices[gone]
    np.testing.assert_allclose(apart[:, 1], 0.0, atol=1e-12)
    np.testing.assert_array_equal(opening.vertices[opening.shape.mesh.faces].max(), kept.max())


def test_components_too_small_to_matter_are_left_out() -> None:
    shape = Shape(shapes.plane_grid(31, 21))
    x = shape.mesh.vertices[shape.mesh.faces, 0]
    opening = Opening.at(shape, (x.min(axis=1) < 1.47) & (x.max(axis=1) > 1.42))
    assert opening.shape.mesh.components == 1
    assert opening.shape.mesh.vertices[:, 0].max() < 1.43


def test_nothing_is_taken_out_of_a_whole_shape() -> None:
    shape = Shape(shapes.blob())
    for opening in (Opening.nowhere(shape), Opening.at(shape, np.zeros(shape.mesh.n_faces, bool))):
        assert opening.shape is shape
        every = np.arange(shape.n_vertices)
        np.testing.assert_array_equal(opening.vertices, every)
        np.testing.assert_array_equal(opening.index_of_vertex, every)
        np.testing.assert_array_equal(opening.faces, np.arange(shape.mesh.n_faces))


@pytest.mark.parametrize("every", [1, 2, 3])
def test_nothing_is_taken_out_where_too_little_would_be_left(every: int) -> None:
    """All triangles, half of them, and a third."""
    shape = Shape(shapes.plane_grid(31, 21))
    out = np.zeros(shape.mesh.n_faces, dtype=np.bool_)
    out[::every] = True
    assert Opening.at(shape, out).shape is shape


def test_a_map_that_sends_one_half_elsewhere_tears_the_triangles_between() -> None:
    mesh = shapes.plane_grid(31, 21, 1.0)
    assert not tears(mesh, mesh.vertices).any()
    right = mesh.vertices[:, 0] > 0.51
    torn = tears(mesh, mesh.vertices + right[:, None] * [0.0, 0.0, 0.5])
    across = right[mesh.faces].any(axis=1) & ~right[mesh.faces].all(axis=1)
    np.testing.assert_array_equal(torn, across)


@pytest.mark.parametrize("finer", [1, 4, 16])
def test_what_is_torn_is_opened_whatever_the_density(finer: int) -> None:
    """A line of triangles that is as long in all of them, though they are a lesser share."""
    columns, rows = 30 * finer, 20 * finer
    shape = Shape(shapes.plane_grid(columns + 1, rows + 1))
    cell = np.arange(shape.mesh.n_faces) % (columns * rows)
    across = cell % columns == columns // 3
    assert torn_length(shape.mesh, across) == pytest.approx(2.0 / np.sqrt(3.0), rel=1e-9)
    assert _torn_open(shape, across).shape is not shape
    beside = across & (cell // columns < rows // 4)
    assert torn_length(shape.mesh, beside) == pytest.approx(0.5 / np.sqrt(3.0), rel=1e-9)
    assert _torn_open(shape, beside).shape is shape


def test_tears_cut_off_the_smaller_piece_of_each_component() -> None:
    grid = shapes.plane_grid(31, 21, 1.0)
    n = grid.n_vertices
    places = np.concatenate([grid.vertices, grid.vertices[:, [1, 0, 2]] + [0.0, 0.0, 2.0]])
    both = triangle_mesh(places, np.concatenate([grid.faces, grid.faces + n]))
    assert both.components == 2
    assert not torn_off(both, both.vertices).any()
    right = both.vertices[:n, 0] > 0.75
    elsewhere = both.vertices.copy()
    elsewhere[:n][right] += [0.0, 0.0, 0.5]
    expected = np.concatenate([right, np.zeros(n, dtype=np.bool_)])
    np.testing.assert_array_equal(torn_off(both, elsewhere), expected)


def test_the_identity_opens_nothing() -> None:
    shape = Shape(shapes.blob())
    every = np.arange(shape.n_vertices)
    ours, theirs = VertexMaps(every, every).openings(shape, shape)
    assert ours.shape is shape
    assert theirs.shape is shape


def test_a_strip_whose_ends_are_glued_is_torn_between_them() -> None:
    """Bent round until they nearly meet, and straight on the other side."""
    columns, rows = 61, 11
    straight = shapes.plane_grid(columns, rows, 4.0)
    angle = straight.vertices[:, 0] / 4.0 * (2.0 * np.pi - 0.1)
    radius = 4.0 / (2.0 * np.pi - 0.1)
    ring = [radius * np.cos(angle), radius * np.sin(angle), straight.vertices[:, 1]]
    last = np.arange(rows) * columns + columns - 1
    first = last - columns + 1
    glue = np.concatenate(
        [
            np.stack([last[:-1], first[:-1], first[1:]], axis=1),
            np.stack([last[:-1], first[1:], last[1:]], axis=1),
        ]
    )
    bent = triangle_mesh(np.stack(ring, axis=1), np.concatenate([straight.faces, glue]))
    assert bent.n_faces == straight.n_faces + len(glue)
    every = np.arange(straight.n_vertices)
    ours, theirs = VertexMaps(every, every).openings(Shape(straight), Shape(bent))
    np.testing.assert_array_equal(ours.faces, np.arange(straight.n_faces))
    np.testing.assert_array_equal(theirs.faces, np.arange(straight.n_faces))
    assert theirs.shape.mesh.area == pytest.approx(
        bent.area - np.linalg.norm(bent.vertices[last[0]] - bent.vertices[first[0]]), rel=1e-9
    )
