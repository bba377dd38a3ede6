"""Refined candidates: their fit, and torn pieces that are put back."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.errors import Cancelled
from solver.mesh import triangle_mesh
from solver.registration import Registration, register
from solver.registration.candidates import first_pairs
from solver.registration.choice import COARSE, FINE, Task, choose
from solver.registration.refinement import (
    RefinedCandidate,
    mend,
    refine_candidate,
)
from solver.registration.surface import smooth_surface
from solver.registration.surface_map import SurfaceMap
from solver.shape import Shape
from synthetic import human


def test_a_copy_fits_exactly_and_others_do_not(blob: Shape) -> None:
    turn = Rotation.from_rotvec([1.0, -2.0, 0.4]).as_matrix()
    copy = Shape(triangle_mesh(3.0 * blob.mesh.vertices @ turn, blob.mesh.faces))
    task = Task.of(blob, copy)
    right, *wrong = choose(
        task,
        lambda samples: first_pairs((task.source, task.target), samples, ()),
        (*COARSE, *FINE),
        Control(),
    )
    refined = refine_candidate(task, right, Control())
    np.testing.assert_array_equal(refined.images, np.arange(blob.n_vertices))
    values = refined.fit.values
    assert max(values["apart"], values["strained"]) < 1e-3
    assert values["turned"] < 0.02
    # Displaced smoothly in space, some become the copy.
    others = [refine_candidate(task, one, Control()) for one in wrong]
    others = [one for one in others if (one.images != refined.images).any()]
    assert others
    for other in others:
        assert other.fit.values["strained"] > 10.0 * values["strained"]
        assert other.fit.score > refined.fit.score + 3.0


@pytest.fixture(scope="module")
def standing() -> Registration:
    """A body registered to itself."""
    figure = human(resolution=1500)
    shape = Shape(triangle_mesh(figure.vertices, figure.faces))
    found = register(shape, shape, [], Control())
    assert found is not None
    np.testing.assert_array_equal(
        found.images(np.arange(shape.n_vertices), Control()), np.arange(shape.n_vertices)
    )
    return found


def exchanged(standing: Registration) -> tuple[tuple[BoolArray, BoolArray], FloatArray]:
    """Vertices of both feet, and by how much all vertices move if they are exchanged."""
    places = smooth_surface(standing.source).mesh.vertices
    foot = places[:, 1] < places[:, 1].min() + 0.18
    feet = foot & (places[:, 0] > 0.0), foot & (places[:, 0] < 0.0)
    apart = places[feet[0]].mean(axis=0) - places[feet[1]].mean(axis=0)
    return feet, -np.subtract(*feet, dtype=float)[:, None] * apart


def test_feet_that_are_exchanged_are_torn_off_and_return(standing: Registration) -> None:
    """As rigidly as possible alone, they stay on the wrong legs."""
    surface = smooth_surface(standing.source)
    right = SurfaceMap.of(surface, surface, standing.candidate.alignment, reflected=False)
    feet, moved = exchanged(standing)
    displaced, images = right.moved(right.positions + moved).refined(surface.at_rest, Control())
    for one, other in (feet, feet[::-1]):
        assert np.isin(images[one], np.flatnonzero(other)).mean() > 0.5
    held = RefinedCandidate(displaced, images)
    mended = mend(held, Control())
    np.testing.assert_array_equal(mended.images, np.arange(len(images)))
    assert mend(held, Control(deadline=time.monotonic())) is held


def test_the_inverse_lies_round_the_nearest_vertices(standing: Registration) -> None:
    surface = smooth_surface(standing.source)
    known = SurfaceMap.of(surface, surface, standing.candidate.alignment, reflected=False)
    vertices, faces, barycentric = known.inverse()
    np.testing.assert_array_equal(known.nearest(), vertices)
    assert (surface.mesh.faces[faces] == vertices[:, None]).any(axis=1).all()
    assert (barycentric >= 0.0).all()
    some = np.arange(0, surface.mesh.n_vertices, 7)
    np.testing.assert_array_equal(known.nearest(some), vertices[some])


def test_sparse_images_are_refined_where_eigenfunctions_exchange_feet(
    standing: Registration,
) -> None:
    """On a surface that is bent a little, so that no rigid motion is the answer."""
    surface, mesh = smooth_surface(standing.source), standing.source.mesh
    bent = mesh.vertices + 0.003 * np.sin(9.0 * mesh.vertices[:, [1, 2, 0]])
    near = register(standing.source, Shape(triangle_mesh(bent, mesh.faces)), [], Control())
    assert near is not None
    known, there = near.candidate, smooth_surface(near.target)
    feet, moved = exchanged(standing)
    foot = np.flatnonzero(np.logical_or(*feet))
    functions = surface.spectrum.eigenfunctions[:, : known.alignment.size]
    further = functions.T @ (surface.spectrum.mass[:, None] * moved) @ known.alignment.turn
    wrong = replace(known.alignment, coefficients=known.alignment.coefficients + further)

    def errors(images: IntArray) -> FloatArray:
        places = surface.mesh.vertices
        found: FloatArray = np.linalg.norm(places[images] - places[foot], axis=1)
        return found

    torn = SurfaceMap.of(surface, there, wrong, reflected=False)
    assert errors(torn.images(foot)).mean() > 0.2
    found = Registration.of(
        near.source, near.target, replace(known, alignment=wrong), near.confidence
    )
    with pytest.raises(Cancelled):
        found.images(foot, Control(is_cancelled=lambda: True))
    assert errors(found.images(foot, Control())).mean() < 0.05
