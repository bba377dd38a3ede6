"""Registrations of pairs whose answer is known."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import Cancelled
from solver.mesh import TriangleMesh, triangle_mesh
from solver.registration import DenseCorrespondence, Registration, register, register_map
from solver.registration.candidates import NO_LANDMARKS
from solver.registration.confidence import RIVAL, UNFINISHED
from solver.registration.surface import SmoothSurface
from solver.shape import Shape
from synthetic import correspondence, human
from tests.solver import shapes

MIRROR = np.array([-1.0, 1.0, 1.0])
LANDMARKS = np.array([0, 10, 40, 77])


def registered(source: Shape, target: Shape) -> tuple[Registration, DenseCorrespondence]:
    found = register(source, target, [], Control())
    assert found is not None
    return found, found.dense(Control())


def moved(mesh: TriangleMesh, scale: float = 1.0) -> TriangleMesh:
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    return triangle_mesh(scale * (mesh.vertices @ turn + [3.0, -1.0, 2.0]), mesh.faces)


def places(dense: DenseCorrespondence, target: Shape) -> FloatArray:
    corners = target.surface.vertices[dense.faces]
    found: FloatArray = np.einsum("vc,vcd->vd", dense.barycentric, corners)
    return found


def test_a_shape_is_registered_to_itself(blob: Shape) -> None:
    found, dense = registered(blob, blob)
    everywhere = np.arange(blob.n_vertices)
    np.testing.assert_array_equal(dense.source, everywhere)
    np.testing.assert_array_equal(dense.target, everywhere)
    np.testing.assert_array_equal(found.images(everywhere[::7], Control()), everywhere[::7])
    assert not found.reflected
    assert found.confidence.probability > 0.99


@pytest.mark.parametrize("change", ["moved", "flipped", "scaled", "permuted"])
def test_a_rigidly_moved_copy_is_found_to_rounding(blob: Shape, change: str) -> None:
    mesh = shapes.blob()
    where: IntArray = np.arange(mesh.n_vertices)
    other = moved(mesh)
    if change == "flipped":
        other = triangle_mesh(other.vertices, other.faces[:, ::-1])
    elif change == "scaled":
        other = moved(mesh, 1000.0)
    elif change == "permuted":
        other, where = shapes.permuted(other, seed=1)
    target = Shape(other, normalise=change != "scaled")
    found, dense = registered(blob, target)
    np.testing.assert_array_equal(dense.target, where)
    images = places(dense, target)
    np.testing.assert_allclose(images, target.surface.vertices[where], atol=1e-6 * target.size)
    assert (dense.barycentric >= 0.0).all()
    np.testing.assert_allclose(dense.barycentric.sum(axis=1), 1.0)
    assert not found.reflected
    assert found.confidence.reasons == ()


@pytest.mark.parametrize("finer", [False, True])
def test_a_symmetric_surface_is_registered_with_doubt(finer: bool) -> None:
    """A ball lies on itself in any position, and a finer triangulation of it."""
    ball, other = shapes.icosphere(2), shapes.icosphere(2 + finer)
    order = np.random.default_rng(5).permutation(other.n_vertices)
    turned = triangle_mesh(other.vertices[order], np.argsort(order)[other.faces])
    found = register(Shape(ball), Shape(turned), (), Control())
    assert found is not None
    assert found.confidence.probability < 0.5
    assert RIVAL in found.confidence.reasons


def test_an_ellipsoid_sampled_anew_is_registered_with_doubt() -> None:
    """Its half-turns fit as well as itself, and only their sampling tells which fits best."""
    ball, axes = shapes.icosphere(3), np.array([1.0, 0.7, 1.8])
    turns = (Rotation.random(random_state=seed).as_matrix() for seed in (6, 7))
    here, there = (Shape(triangle_mesh(ball.vertices @ turn * axes, ball.faces)) for turn in turns)
    found = register(here, there, (), Control())
    assert found is not None
    assert found.confidence.probability < 0.5
    assert RIVAL in found.confidence.reasons


def test_a_torus_is_registered_to_its_copy_with_doubt() -> None:
    torus = Shape(shapes.torus(16, 8))
    found = register(torus, torus, (), Control())
    assert found is not None
    assert found.confidence.probability < 0.5


def test_the_inverse_of_a_permuted_copy_is_the_inverse_permutation(blob: Shape) -> None:
    other, where = shapes.permuted(moved(shapes.blob()), seed=1)
    _, dense = registered(blob, Shape(other))
    assert dense.inverse is not None
    np.testing.assert_array_equal(dense.inverse.source, np.arange(other.n_vertices))
    np.testing.assert_array_equal(dense.inverse.target[where], np.arange(len(where)))
    vertices = blob.surface.vertices
    found = places(dense.inverse, blob)[where]
    np.testing.assert_allclose(found, vertices, atol=1e-6 * blob.size)


def test_the_inverse_covers_a_finer_triangulation_and_returns_to_it(blob: Shape) -> None:
    """All fine vertices have a preimage, though the coarse ones reach a quarter of them."""
    fine = shapes.blob(4)
    target = Shape(moved(fine))
    _, dense = registered(blob, target)
    inverse = dense.inverse
    assert inverse is not None
    assert len(np.unique(dense.target)) < 0.3 * fine.n_vertices
    np.testing.assert_array_equal(inverse.source, np.arange(fine.n_vertices))
    assert (inverse.barycentric >= 0.0).all()
    np.testing.assert_allclose(inverse.barycentric.sum(axis=1), 1.0)
    apart = places(inverse, blob) - Shape(fine).surface.vertices
    assert np.linalg.norm(apart, axis=1).mean() < 0.02 * blob.size
    there = places(dense, target)[inverse.faces]
    back = np.einsum("vc,vcd->vd", inverse.barycentric, there) - target.surface.vertices
    assert np.linalg.norm(back, axis=1).mean() < 0.02 * target.size


@pytest.mark.parametrize("size", [0.04, 0.08])
def test_a_smooth_displacement_is_recovered(surface: SmoothSurface, size: float) -> None:
    """In the first eigenfunctions, by a share of √area; edges are 0.05 long."""
    mesh = surface.mesh
    functions = surface.spectrum.eigenfunctions[:, 1:9]
    displacement = functions @ np.random.default_rng(0).standard_normal((8, 3))
    displacement *= size / np.abs(displacement).max()
    source = Shape(mesh)
    target = Shape(moved(triangle_mesh(mesh.vertices + displacement, mesh.faces)))
    found, dense = registered(source, target)
    errors = np.linalg.norm(places(dense, target) - target.surface.vertices, axis=1) / target.size
    assert errors.mean() < 0.5 * size
    assert errors.max() < 0.12
    assert found.confidence.probability > 0.9
    assert not found.reflected


def test_a_finer_triangulation_is_registered_within_sampling(blob: Shape) -> None:
    """A vertex of the coarse one is a vertex of the fine one."""
    fine = shapes.blob(4)
    target = Shape(moved(fine))
    _, dense = registered(blob, target)
    truth = np.linalg.norm(shapes.blob().vertices[:, None] - fine.vertices[None], axis=2).argmin(
        axis=1
    )
    apart = places(dense, target) - target.surface.vertices[truth]
    errors = np.linalg.norm(apart, axis=1) / target.size
    assert errors.mean() < 0.01
    assert errors.max() < 0.06


def test_a_mirrored_copy_is_recognised_by_landmarks(blob: Shape) -> None:
    mesh = shapes.blob()
    target = Shape(moved(triangle_mesh(mesh.vertices * MIRROR, mesh.faces)))
    points = LANDMARKS, LANDMARKS
    # Without time for a search of better answers, which there are none of.
    found = register(blob, target, [points], Control(deadline=time.monotonic()), points)
    assert found is not None
    assert found.reflected
    np.testing.assert_array_equal(found.dense(Control()).target, np.arange(blob.n_vertices))
    direct = register(blob, blob, [], Control(deadline=time.monotonic()), points)
    assert direct is not None
    assert not direct.reflected


@pytest.mark.parametrize("seed", [0, 2])
def test_landmarks_between_left_and_right_do_not_mean_the_mirror_image(seed: int) -> None:
    """Both the direct answer and its mirror image meet them."""
    figure = human("standing", resolution=700, seed=1)
    other = human("walking", resolution=800, seed=2)
    truth = correspondence(figure, other)
    middle = np.flatnonzero(np.abs(figure.rest[:, 0]) < 0.01 * np.ptp(figure.rest[:, 1]))
    here = np.random.default_rng(seed).choice(middle, 3, replace=False)
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in (figure, other))
    found = register(source, target, [], Control(), (here, truth[here]))
    assert found is not None
    assert not found.reflected
    images = found.images(np.arange(source.n_vertices), Control())
    errors = np.linalg.norm(
        target.surface.vertices[images] - target.surface.vertices[truth], axis=1
    )
    assert errors.mean() < 0.05


def test_a_mirrored_copy_of_a_body_without_symmetry_is_recognised(blob: Shape) -> None:
    mesh = shapes.blob()
    found, dense = registered(blob, Shape(triangle_mesh(mesh.vertices * MIRROR, mesh.faces)))
    assert found.reflected
    np.testing.assert_array_equal(dense.target, np.arange(blob.n_vertices))


def test_a_symmetric_body_in_the_mirrored_pose_is_registered_directly() -> None:
    """Left of the one is left of the other: vertices of the other side."""
    figure, other = (human("walking", resolution=1000, seed=seed) for seed in (1, 2))
    source = Shape(triangle_mesh(figure.vertices, figure.faces))
    target = Shape(triangle_mesh(other.vertices * MIRROR, other.faces))
    found, dense = registered(source, target)
    assert not found.reflected
    images = other.rest[dense.target]
    assert np.linalg.norm(figure.rest - images * MIRROR, axis=1).mean() < 0.1
    assert np.linalg.norm(figure.rest - images, axis=1).mean() > 0.2


def test_a_registration_is_deterministic() -> None:
    """Computed anew, from equal meshes."""
    mesh, other = shapes.blob(), moved(shapes.blob(2))
    results = [registered(Shape(mesh), Shape(other)) for _ in range(2)]
    (one, first), (two, second) = results
    assert one.score == two.score
    assert one.confidence.probability == two.confidence.probability
    np.testing.assert_array_equal(first.target, second.target)
    np.testing.assert_array_equal(first.barycentric, second.barycentric)


def test_a_registration_without_time_has_an_answer(blob: Shape) -> None:
    points = np.arange(0, blob.n_vertices, 20)
    control = Control().within(0.0)
    found = register(blob, blob, [(points, points)], control)
    assert found is not None
    assert UNFINISHED in found.confidence.reasons
    dense = found.dense(control)
    assert len(dense.target) == blob.n_vertices
    np.testing.assert_allclose(dense.barycentric.sum(axis=1), 1.0)


def test_cancellation_leaves(blob: Shape) -> None:
    found = register(blob, blob, [], Control())
    assert found is not None
    cancelled = Control(is_cancelled=lambda: True)
    with pytest.raises(Cancelled):
        register(blob, blob, [], cancelled)
    with pytest.raises(Cancelled):
        found.dense(cancelled)


def test_a_mesh_of_few_vertices_is_not_registered() -> None:
    small = Shape(shapes.triangle())
    assert register(small, small, [], Control(), NO_LANDMARKS) is None


def test_vertex_numbers_are_the_users_own(blob: Shape) -> None:
    mesh = shapes.blob()
    stray = np.full((1, 3), 50.0)
    padded = Shape(triangle_mesh(np.concatenate([stray, mesh.vertices]), mesh.faces + 1))
    _, dense = registered(padded, blob)
    np.testing.assert_array_equal(dense.source, dense.target + 1)
    _, back = registered(blob, padded)
    np.testing.assert_array_equal(back.target, back.source + 1)
    assert (back.faces >= 1).all()
    assert dense.inverse is not None
    np.testing.assert_array_equal(dense.inverse.target, dense.inverse.source + 1)
    assert (dense.inverse.faces >= 1).all()


def test_a_map_is_registered_where_it_puts_the_source(blob: Shape) -> None:
    """A half-turn of a body without symmetry stays another map, and fits worse."""
    every, vertices = np.arange(blob.n_vertices), blob.mesh.vertices
    turned: IntArray = np.asarray(KDTree(vertices).query(vertices * [-1.0, -1.0, 1.0])[1])
    right, wrong = (register_map(blob, blob, one, one, Control()) for one in (every, turned))
    np.testing.assert_array_equal(right.images(every, Control()), every)
    assert right.is_exact
    assert wrong.differs_from(right)
    assert not right.differs_from(right)
    assert wrong.score > right.score
    assert right.among(right).confidence.margin == 0.0
    assert right.among(wrong).confidence.margin == min(wrong.score - right.score, 1.0)
    assert wrong.among(right).confidence.margin == 0.0
    assert RIVAL in wrong.among(right).confidence.reasons
    unfinished = replace(right, confidence=replace(right.confidence, reasons=(UNFINISHED,)))
    assert UNFINISHED in unfinished.among(wrong).confidence.reasons
