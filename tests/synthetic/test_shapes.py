"""Generated shapes: closed surfaces of the right topology whose ground truth is true."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver.arrays import IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape.geodesics import GeodesicGraph
from synthetic import CLASSES, SyntheticShape, articulated, correspondence
from synthetic.remeshing import edges_of
from synthetic.skeleton import Figure, Flesh, Joint
from synthetic.surface import skin

_VERTICES = 800
_POSED = [(category, pose) for category, known in CLASSES.items() for pose in known.poses]


def mesh_of(shape: SyntheticShape) -> TriangleMesh:
    return triangle_mesh(shape.vertices, shape.faces)


def euler_characteristic(mesh: TriangleMesh) -> int:
    return mesh.n_vertices - len(edges_of(mesh.faces)) + len(mesh.faces)


def scattered(shape: SyntheticShape, count: int = 24) -> IntArray:
    """Vertices spread over the body."""
    return np.random.default_rng(1).choice(len(shape.rest), count, replace=False)


def test_six_classes_of_four_poses() -> None:
    assert len(CLASSES) == 6
    assert all(len(known.poses) == 4 for known in CLASSES.values())


@pytest.mark.parametrize(("category", "pose"), _POSED)
def test_a_closed_surface_of_genus_0(category: str, pose: str) -> None:
    shape = articulated(category, pose, _VERTICES)
    mesh = mesh_of(shape)
    assert mesh.n_vertices == _VERTICES
    assert mesh.components == 1
    assert mesh.closed
    assert euler_characteristic(mesh) == 2
    corners = shape.vertices[shape.faces]
    volume = np.einsum("fd,fd->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume > 0.0, "oriented inwards"


@pytest.mark.parametrize("category", CLASSES)
def test_poses_are_nearly_isometric(category: str) -> None:
    first, *others = [articulated(category, pose, _VERTICES) for pose in CLASSES[category].poses]
    points = scattered(first)
    distances = GeodesicGraph(mesh_of(first)).distances(points)[:, points]
    far = distances > 0.1 * distances.max()
    for other in others:
        graph = GeodesicGraph(mesh_of(other))
        change = graph.distances(points)[:, points][far] / distances[far] - 1.0
        assert np.abs(change).mean() < 0.08
        assert mesh_of(other).area == pytest.approx(mesh_of(first).area, rel=0.04)


@pytest.mark.parametrize("category", CLASSES)
def test_triangulations_differ_and_their_points_agree(category: str) -> None:
    first, second = list(CLASSES[category].poses)[:2]
    one, other = (
        articulated(category, first, _VERTICES),
        articulated(category, second, _VERTICES, 1),
    )
    edge = np.sqrt(2.0 * mesh_of(one).area / _VERTICES)
    apart = np.linalg.norm(one.rest - other.rest[correspondence(one, other)], axis=1)
    assert 0.15 * edge < apart.mean() < 0.6 * edge
    assert apart.max() < 2.5 * edge


@pytest.mark.parametrize("category", CLASSES)
def test_figures_are_their_own_mirror_images(category: str) -> None:
    figure = CLASSES[category].figure
    ends = np.concatenate([figure.cones().start, figure.cones().end])
    assert KDTree(ends).query(ends * np.array([-1.0, 1.0, 1.0]))[0] == pytest.approx(0.0)


def test_the_same_seed_gives_the_same_triangulation() -> None:
    joint = Joint("root", None, (0.0, 0.0, 0.0))
    cone = Flesh("root", (0.0, 0.0, 0.0), 0.1, (0.0, 0.3, 0.0), 0.05)
    figure = Figure((joint,), (cone,), blend=0.01, landmarks=())
    one = skin(figure, 300, seed=3)
    # Another name, so that nothing kept from before is used.
    other = skin(replace(figure, landmarks=(("tip", cone.end),)), 300, seed=3)
    np.testing.assert_array_equal(one[0], other[0])
    np.testing.assert_array_equal(one[1], other[1])
    assert not np.array_equal(one[0], skin(figure, 300, seed=4)[0])
