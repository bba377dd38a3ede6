"""Labellings of a part: those that differ are tried, and all keep landmarks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.arrays import IntArray
from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration.candidates import NO_LANDMARKS, Points
from solver.registration.choice import Stage
from solver.registration.partial.candidates import alignment_by_distances, labelled_points
from solver.registration.partial.partiality import OF_PART, Labellings
from solver.registration.partial.task import PartTask
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from tests.solver.shapes import blob


@pytest.mark.parametrize("occlusion_cost", [np.inf, 0.01])
def test_landmarks_are_matched_even_if_they_contradict_all_distances(occlusion_cost: float) -> None:
    shape = Shape(blob(3))
    first = shape.sampling("geodesic", 3).indices
    # Two far points are said to be where two near ones are.
    near = shape.metric("geodesic").distances(first[:1])[0].argsort()[[0, 1]]
    landmarks = first[:2], near
    how = Labellings(6, (1.0,), 5, ((occlusion_cost, 0.0),), 5, 0.0)
    found = list(labelled_points(shape, shape, 1.0, how, landmarks, Control()))
    assert found
    for here, there in found:
        pairs = set(zip(here.tolist(), there.tolist(), strict=True))
        assert set(zip(*(one.tolist() for one in landmarks), strict=True)) <= pairs


def points(shape: Shape, how: Labellings) -> list[Points]:
    return list(labelled_points(shape, shape, 1.0, how, NO_LANDMARKS, Control()))


def test_a_shape_is_labelled_with_itself() -> None:
    shape = Shape(blob(3))
    how = Labellings(8, (1.0,), 1, ((np.inf, 0.0),), 1, 0.0)
    ((here, there),) = points(shape, how)
    np.testing.assert_array_equal(here, there)


def test_the_best_labellings_are_tried_and_others_that_differ() -> None:
    shape = Shape(blob(3))
    best, apart = 3, 0.2
    enumerated = Labellings(6, (1.0,), 300, ((np.inf, 0.0),), 300, 0.0)
    every = [there for there, _ in points(shape, enumerated)]
    tried = [there for there, _ in points(shape, replace(enumerated, best=best, apart=apart))]
    assert len(every) == 300
    np.testing.assert_array_equal(tried[:best], every[:best])
    distances = shape.metric("geodesic").distances(np.arange(shape.n_vertices)) / shape.size

    def differ(one: IntArray, others: list[IntArray]) -> bool:
        return all(distances[one, other].mean() > apart for other in others)

    assert all(differ(one, tried[:place]) for place, one in enumerate(tried) if place >= best)
    # Whatever is left out is like one of those that are tried.
    assert best < len(tried) < len(every)
    assert not any(differ(one, tried) for one in every)


def test_unmatched_points_make_labellings_differ() -> None:
    shape = Shape(blob(3))
    how = Labellings(6, (1.0,), 300, ((0.01, 0.0),), 1, 0.1)
    sizes = {len(there) for there, _ in points(shape, how)}
    assert len(sizes) > 1


def test_points_as_far_from_the_labelled_ones_correspond() -> None:
    """The displaced whole lies on a copy that was turned, moved and scaled."""
    mesh = blob(3)
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    copy = triangle_mesh(3.0 * (mesh.vertices @ turn + [3.0, -1.0, 2.0]), mesh.faces)
    whole, part = Shape(mesh), Shape(copy)
    known = whole.sampling("geodesic", 4).indices
    surfaces = smooth_surface(whole), smooth_surface(part)
    samples = PartTask((whole, part), OF_PART).sampled(Stage(200, 400, (), 1))
    found = alignment_by_distances((whole, part), samples, (known, known), 1.0)
    smooth = surfaces[1].samples.coefficients[: found.size]
    there, _ = surfaces[1].samples.first(200).surface(smooth)
    displaced, _ = samples[0].surface(found.coefficients)
    assert np.linalg.norm(displaced - there, axis=1).mean() < 0.02
