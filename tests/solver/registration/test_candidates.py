"""First candidates: rotations in space, of shapes whose eigenfunctions do not agree."""

import numpy as np
from scipy.spatial.transform import Rotation
from skimage.measure import marching_cubes

from solver.control import Control
from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration.candidates import first_pairs
from solver.registration.pairwise import register
from solver.registration.surface import SmoothSurface, smooth_surface
from solver.shape import Shape


def hollow(seed: int, holes: int = 5) -> TriangleMesh:
    """Triangulate a hollow body of no symmetry, with holes in its wall that differ by the seed."""
    axis = np.linspace(-1.3, 1.3, 44)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    body = np.linalg.norm(points / (1.0, 0.62, 0.5), axis=-1) - 1.0
    horn = np.linalg.norm((points - (0.75, 0.25, 0.35)) / (0.3, 0.22, 0.35), axis=-1) - 1.0
    wall = np.abs(0.5 * np.minimum(body, horn) + 0.08) - 0.08
    directions = np.random.default_rng(seed).normal(size=(holes, 3))
    for way in directions / np.linalg.norm(directions, axis=1, keepdims=True):
        along = np.maximum(points @ way, 0.0)[..., None]
        wall = np.maximum(wall, 0.1 - np.linalg.norm(points - along * way, axis=-1))
    vertices, faces, _, _ = marching_cubes(wall, 0.0)
    return triangle_mesh(vertices * (axis[1] - axis[0]) - 1.3, faces)


def test_a_rotated_copy_is_a_candidate_at_once(blob: Shape, surface: SmoothSurface) -> None:
    mesh = blob.mesh
    moved = Shape(
        mesh.with_same_faces(
            vertices=mesh.vertices @ Rotation.random(random_state=0).as_matrix() + 3.0
        )
    )
    chosen = np.arange(0, mesh.n_vertices, mesh.n_vertices // 200)
    here, there = surface.at(chosen), smooth_surface(moved).at(chosen)
    *_, rotated = first_pairs((surface, smooth_surface(moved)), (here, there), ())
    np.testing.assert_array_equal(rotated.images, np.arange(len(chosen)))


def test_hollow_bodies_with_unlike_holes_are_matched_as_they_lie_in_space() -> None:
    turn = Rotation.random(random_state=1).as_matrix()
    source, target = hollow(2), hollow(3)
    assert source.genus > 0.0
    turned = Shape(target.with_same_faces(vertices=target.vertices @ turn))
    found = register(Shape(source), turned, (), Control())
    assert found is not None
    images = found.images(np.arange(source.n_vertices), Control())
    apart = np.linalg.norm(target.vertices[images] - source.vertices, axis=1) / turned.unit
    assert apart.mean() < 0.02
