"""Reduced surfaces: what they keep, and that the answer is that of the whole ones."""

import numpy as np
import pytest

from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import register, search
from solver.registration.choice import FINE, Candidate, Task
from solver.registration.comparison import best_compared, compare
from solver.registration.opening import VertexMaps
from solver.registration.reduction import ReducedTask, Reduction, reduced_landmarks, whole_maps
from solver.shape import Shape
from tests.solver import shapes

LEFT = 400


@pytest.fixture
def reduced(blob: Shape, monkeypatch: pytest.MonkeyPatch) -> Reduction:
    monkeypatch.setattr(search, "FEW_VERTICES", LEFT)
    return Reduction.of(blob, LEFT)


def test_a_shape_of_few_vertices_is_its_own_reduction(blob: Shape) -> None:
    whole = Reduction.of(blob, 500)
    assert whole.shape is blob
    np.testing.assert_array_equal(whole.vertices, np.arange(blob.n_vertices))
    np.testing.assert_array_equal(whole.index_of_vertex, np.arange(blob.n_vertices))


def test_vertices_keep_their_places(blob: Shape, reduced: Reduction) -> None:
    positions, fewer = blob.mesh.vertices, reduced.shape.mesh.vertices
    assert len(fewer) == LEFT < blob.n_vertices
    np.testing.assert_array_equal(positions[reduced.vertices], fewer)
    np.testing.assert_array_equal(reduced.index_of_vertex[reduced.vertices], np.arange(LEFT))
    apart = np.linalg.norm(positions - fewer[reduced.index_of_vertex], axis=1)
    assert apart.max() < 0.2 * np.sqrt(blob.mesh.area)


def test_numbers_are_those_of_the_mesh_not_of_the_file(blob: Shape, reduced: Reduction) -> None:
    """The first seven vertices of the file are not in the mesh."""
    vertices = np.concatenate([blob.mesh.vertices[:7] + 9.0, blob.mesh.vertices])
    whole = Shape(triangle_mesh(vertices, blob.mesh.faces + 7))
    again = Reduction.of(whole, LEFT)
    np.testing.assert_array_equal(again.vertices, reduced.vertices)
    np.testing.assert_array_equal(again.index_of_vertex, reduced.index_of_vertex)


def test_maps_of_reduced_shapes_are_maps_of_all_vertices(blob: Shape, reduced: Reduction) -> None:
    every = np.arange(len(reduced.vertices))
    maps = whole_maps(VertexMaps(every, every[::-1]), reduced, reduced)
    np.testing.assert_array_equal(maps.images, reduced.vertices[reduced.index_of_vertex])
    np.testing.assert_array_equal(maps.back, reduced.vertices[::-1][reduced.index_of_vertex])


def test_landmarks_that_become_one_are_one(blob: Shape, reduced: Reduction) -> None:
    collapsed = int(np.setdiff1d(np.arange(blob.n_vertices), reduced.vertices)[0])
    same = int(reduced.vertices[reduced.index_of_vertex[collapsed]])
    entire = Reduction(blob, np.arange(blob.n_vertices), np.arange(blob.n_vertices))
    landmarks = np.array([7, collapsed, same]), np.array([1, 2, 3])
    here, there = reduced_landmarks(reduced, entire, landmarks)
    np.testing.assert_array_equal(here, reduced.index_of_vertex[[7, collapsed]])
    np.testing.assert_array_equal(there, [1, 2])
    for one, given in zip(reduced_landmarks(entire, entire, landmarks), landmarks, strict=True):
        np.testing.assert_array_equal(one, given)


def test_pairs_of_the_whole_are_pairs_of_the_reduced(
    blob: Shape, reduced: Reduction, found: list[Candidate]
) -> None:
    """A copy's samples, which lie at the same vertices, are paired with themselves."""
    task = Task.of(blob, blob)
    best = found[0]
    for one in (task, task.reflected()):
        fewer = ReducedTask.of(blob, blob, one, LEFT)
        assert fewer.task.source.mesh.n_vertices == LEFT
        assert fewer.task.is_reflected == one.is_reflected
        assert all(one.is_reflected == each.reflection for each in fewer.whole[:1])
    pairs = ReducedTask.of(blob, blob, task, LEFT).pairs(best.alignment, FINE[-1])
    np.testing.assert_array_equal(pairs.images, np.arange(len(pairs.images)))


def test_the_same_candidate_is_chosen(
    blob: Shape, reduced: Reduction, found: list[Candidate]
) -> None:
    task = Task.of(blob, blob)
    fewer, entire = (
        [one.candidate for one in best_compared(compare(few, found[:3], Control()))]
        for few in (ReducedTask.of(blob, blob, task, LEFT), ReducedTask.entire(task))
    )
    assert fewer[0] is found[0]
    assert [id(one) for one in fewer] == [id(one) for one in entire]


def test_an_answer_with_rivals_is_one_of_the_whole_shapes(
    reduced: Reduction,
) -> None:
    """An ellipsoid lies on a copy in four ways; of the whole one, every vertex is met exactly."""
    sphere = shapes.icosphere(3)
    one = Shape(triangle_mesh(sphere.vertices * [1.0, 0.7, 1.8], sphere.faces))
    found = register(one, one, [], Control())
    assert found is not None
    assert "refined_score" in found.confidence.measures
    dense = found.dense(Control())
    np.testing.assert_array_equal(dense.source, np.arange(one.n_vertices))
    here, there = one.mesh.vertices[dense.source], one.mesh.vertices[dense.target]
    rotations = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    np.testing.assert_array_equal(
        min(np.abs(here * signs - there).max() for signs in rotations), 0.0
    )
