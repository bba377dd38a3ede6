"""Displacements that are smooth in space: exact cases, sliding, thin walls that stay near."""

from dataclasses import dataclass

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import Registration, register
from solver.registration.partial import register_part
from solver.registration.spatial import SpatialDisplacement, displaced_in_space
from solver.registration.surface import smooth_surface
from solver.registration.surface_map import SurfaceMap
from solver.shape import Shape
from synthetic import skull
from tests.solver.shapes import icosphere

WIDTH = 0.5


@pytest.fixture(scope="module")
def sphere() -> FloatArray:
    return icosphere(4).vertices


def fitted(points: FloatArray, goals: FloatArray, normals: FloatArray) -> SpatialDisplacement:
    return SpatialDisplacement.fit(points, goals, normals, points[:60], WIDTH)


def test_an_affine_map_is_recovered_without_kernels(sphere: FloatArray) -> None:
    matrix = np.array([[1.1, 0.2, 0.0], [-0.3, 0.9, 0.1], [0.0, 0.1, 1.2]])
    found = fitted(sphere, sphere @ matrix + (1.0, 2.0, 3.0), sphere)
    np.testing.assert_allclose(found.affine, [*matrix, (1.0, 2.0, 3.0)], atol=1e-5)
    assert np.abs(found.weights).max() < 1e-4


def bent(points: FloatArray) -> FloatArray:
    x, y, z = points.T
    return np.stack([x + 0.2 * np.sin(y), y + 0.2 * np.cos(z), z + 0.3 * np.sin(x)], axis=1)


def test_a_smooth_displacement_is_followed_where_no_point_was_given(sphere: FloatArray) -> None:
    found = fitted(sphere[::2], bent(sphere[::2]), sphere[::2])
    error = np.linalg.norm(found.positions(sphere[1::2]) - bent(sphere[1::2]), axis=1)
    moved = np.linalg.norm(bent(sphere) - sphere, axis=1)
    assert error.max() < 0.1 * moved.mean()


def on_cube(count: int) -> tuple[FloatArray, FloatArray]:
    """Points of a cube's faces, and the normals there."""
    steps = np.linspace(-0.95, 0.95, count)
    plane = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    faces = [(axis, side) for axis in range(3) for side in (-1.0, 1.0)]
    points = np.concatenate([np.insert(plane, axis, side, axis=1) for axis, side in faces])
    normals = np.concatenate(
        [np.tile(side * np.eye(3)[axis], (len(plane), 1)) for axis, side in faces]
    )
    return points, normals


def test_goals_that_slide_within_the_surface_hardly_draw() -> None:
    points, normals = on_cube(12)
    sliding = np.where(np.abs(normals[:, 2:]) > 0.0, (0.1, 0.0, 0.0), 0.0) * points[:, 2:]
    assert np.abs((sliding * normals).sum(axis=1)).max() == 0.0
    slid = fitted(points, points + sliding, normals).positions(points) - points
    assert np.linalg.norm(slid, axis=1).max() < 0.02
    raised = fitted(points, points + 0.1 * normals, normals).positions(points) - points
    np.testing.assert_allclose((raised * normals).sum(axis=1), 0.1, atol=0.01)


@dataclass(frozen=True, eq=False)
class Bones:
    """Two individuals, their registration, and the true places of the source's vertices."""

    source: Shape
    target: Shape
    truth: FloatArray
    found: Registration

    def error(self, images: FloatArray) -> float:
        """Mean distance of images of the source's vertices, over √area."""
        apart = np.linalg.norm(images - self.truth, axis=1)
        return float(apart.mean() / self.target.unit)


@pytest.fixture(scope="module")
def bones() -> Bones:
    one, other = skull(1, 0.8, 0.45), skull(3, 0.8, 0.45)
    source, target = (Shape(triangle_mesh(each.vertices, each.faces)) for each in (one, other))
    found = register(source, target, (), Control())
    assert found is not None
    return Bones(source, target, other.displacement(one.rest), found)


def test_it_is_nearer_to_the_truth_than_eigenfunctions_on_thin_walls(bones: Bones) -> None:
    surfaces = smooth_surface(bones.source), smooth_surface(bones.target)
    known = SurfaceMap.of(*surfaces, bones.found.candidate.alignment, reflected=False)
    vertices = bones.target.mesh.vertices
    along, in_space = (
        bones.error(vertices[each.images()]) for each in (known, displaced_in_space(known))
    )
    assert in_space < 0.6 * along


def test_the_dense_map_takes_it_where_it_fits_better(bones: Bones) -> None:
    dense = bones.found.dense(Control())
    corners = bones.target.mesh.vertices[dense.faces]
    assert bones.error(np.einsum("nc,ncd->nd", dense.barycentric, corners)) < 0.013


def test_so_does_the_map_of_a_part(bones: Bones) -> None:
    whole, other = bones.target.mesh, bones.source.mesh
    side = other.vertices[:, 0]
    kept = np.flatnonzero(side > np.median(side) - 0.1 * np.ptp(side))
    faces = other.faces[np.isin(other.faces, kept).all(axis=1)]
    kept = np.unique(faces)
    part = triangle_mesh(other.vertices[kept], np.searchsorted(kept, faces))
    scale = float(np.sqrt(whole.area / part.area))
    found = register_part(bones.target, Shape(part), Control(), scale=scale)
    assert found is not None
    _, triangles, barycentric = found.target.images
    images = np.einsum("nc,ncd->nd", barycentric, whole.vertices[whole.faces[triangles]])
    apart = np.linalg.norm(images - bones.truth[kept], axis=1)
    assert apart.mean() < 0.014 * bones.target.unit
