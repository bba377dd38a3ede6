"""Registration of surfaces whose parts are glued together."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver.control import Control
from solver.mesh import triangle_mesh
from solver.registration import glued as module
from solver.registration import reduction
from solver.registration.candidates import Points
from solver.registration.choice import Task
from solver.registration.confidence import OPENED, Confidence
from solver.registration.glued import OpenedCandidate, search_opened
from solver.registration.opening import Crease, VertexMaps
from solver.registration.pairwise import register
from solver.registration.reduction import ReducedTask
from solver.registration.refinement import refine_on_few
from solver.registration.registration import Registration
from solver.shape import Shape
from synthetic import Transformed, glued, human, near_in_space
from tests.solver import shapes

FINER = 4

RIMS = 0.15
"""Geodesic radius of the discs between which the tube is."""


@pytest.fixture(scope="module")
def body() -> Shape:
    return Shape(shapes.blob(FINER))


@pytest.fixture(scope="module")
def with_glue(body: Shape) -> Transformed:
    """Two bumps of the body, far apart along the surface, connected by a tube."""
    mesh = body.mesh
    highest = np.argsort(-np.linalg.norm(mesh.vertices, axis=1))
    first = int(highest[0])
    apart = np.linalg.norm(mesh.vertices - mesh.vertices[first], axis=1)
    second = int(next(one for one in highest if apart[one] > 1.5))
    return glued(mesh, np.array([[first, second]]), RIMS)


@pytest.fixture(scope="module")
def found(body: Shape, with_glue: Transformed) -> tuple[OpenedCandidate, Confidence]:
    """Found from the true partners of some points."""
    return through_the_glue(body, with_glue)


def torn_nowhere(source: Shape, target: Shape) -> VertexMaps:
    """Maps that say nothing: all vertices go to the first."""
    return VertexMaps(*(np.zeros(one.n_vertices, dtype=np.int64) for one in (source, target)))


def through_the_glue(body: Shape, with_glue: Transformed) -> tuple[OpenedCandidate, Confidence]:
    target = Shape(with_glue.mesh)
    points = np.flatnonzero(with_glue.kept)[::40]

    def rematch(ours: Shape, theirs: Shape) -> list[Points]:
        here, there = (one.mesh.vertices for one in (ours, theirs))
        places = body.mesh.vertices[points]
        nearest = [
            np.linalg.norm(places[:, None] - one[None], axis=2).argmin(axis=1)
            for one in (here, there)
        ]
        return [(nearest[0], nearest[1])]

    searched = search_opened(body, target, torn_nowhere(body, target), rematch, np.inf, Control())
    assert searched is not None
    return searched


def test_a_body_is_matched_through_the_glue(
    found: tuple[OpenedCandidate, Confidence], body: Shape, with_glue: Transformed
) -> None:
    assert error_of(found[0], body, with_glue) < 0.02


def test_its_confidence_is_of_its_refined_fit(found: tuple[OpenedCandidate, Confidence]) -> None:
    ours, theirs = (one.shape for one in found[0].openings)
    few = ReducedTask.of(ours, theirs, Task.of(ours, theirs), reduction.FEW_VERTICES)
    refined = refine_on_few(few, found[0].candidate, Control())
    assert found[1].measures["refined_score"] == pytest.approx(refined.fit.score)
    assert found[0].on_few(Control()) is found[0].on_few(Control())


def test_a_body_of_many_vertices_is_opened_on_fewer(
    body: Shape, with_glue: Transformed, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reduction, "MANY_VERTICES", 1300)
    found = through_the_glue(body, with_glue)
    assert all(one.shape.n_vertices > 2000 for one in found[0].openings)
    assert error_of(found[0], body, with_glue) < 0.02


def error_of(found: OpenedCandidate, body: Shape, with_glue: Transformed) -> float:
    here = np.flatnonzero(with_glue.kept)
    images = with_glue.mesh.vertices[found.images(here, Control())]
    errors = np.linalg.norm(images - body.mesh.vertices[here], axis=1) / np.sqrt(body.mesh.area)
    return float(errors.mean())


def test_the_known_answer_is_opened_where_it_tears(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hand that is glued to the hip, and lifted. Without any crease, nothing else is tried."""
    monkeypatch.setattr(module, "CREASES", (Crease(0.01, 2.0),))
    lifted, lowered = (
        triangle_mesh(one.vertices, one.faces)
        for one in (human(pose, resolution=1500, seed=1) for pose in ("reaching", "standing"))
    )
    changed = glued(lowered, near_in_space(lowered, 1, 0.6), 0.04)
    source, target = Shape(lifted), Shape(changed.mesh)
    known = VertexMaps(
        np.asarray(KDTree(changed.mesh.vertices).query(lowered.vertices)[1]),
        np.asarray(KDTree(lowered.vertices).query(changed.mesh.vertices)[1]),
    )
    found = search_opened(source, target, known, _none, np.inf, Control())
    assert found is not None
    assert found[0].openings[1].shape.mesh.genus == 0.0 < target.mesh.genus
    images = changed.mesh.vertices[found[0].images(np.arange(source.n_vertices), Control())]
    errors = np.linalg.norm(images - lowered.vertices, axis=1) / target.unit
    assert errors.mean() < 0.02


def test_what_fits_less_well_than_asked_is_none(body: Shape, with_glue: Transformed) -> None:
    target = Shape(with_glue.mesh)
    known = torn_nowhere(body, target)
    assert search_opened(body, target, known, lambda _ours, _theirs: [], -np.inf, Control()) is None


def test_maps_of_opened_surfaces_are_maps_of_all_vertices(
    found: tuple[OpenedCandidate, Confidence], body: Shape, with_glue: Transformed
) -> None:
    target = Shape(with_glue.mesh)
    dense = Registration(body, target, *found).dense(Control())
    np.testing.assert_array_equal(dense.source, np.arange(body.n_vertices))
    here = np.flatnonzero(with_glue.kept)
    places = with_glue.mesh.vertices[dense.target[here]]
    errors = np.linalg.norm(places - body.mesh.vertices[here], axis=1) / np.sqrt(body.mesh.area)
    assert errors.mean() < 0.005
    np.testing.assert_allclose(dense.barycentric.sum(axis=1), 1.0)
    corners = np.sort(dense.faces, axis=1)
    triangles = {tuple(one) for one in np.sort(target.mesh.faces, axis=1).tolist()}
    assert {tuple(one) for one in corners.tolist()} <= triangles
    assert (dense.target[:, None] == dense.faces).any(axis=1).mean() > 0.95
    assert dense.inverse is not None
    np.testing.assert_array_equal(dense.inverse.source, np.arange(target.n_vertices))


def test_smooth_surfaces_are_not_opened() -> None:
    sphere = Shape(shapes.icosphere(3))
    every = np.arange(sphere.n_vertices)
    assert search_opened(sphere, sphere, VertexMaps(every, every), _none, np.inf, Control()) is None


def test_a_ring_that_is_opened_until_it_fits_a_ball_is_doubted() -> None:
    ring, ball = Shape(shapes.torus()), Shape(shapes.icosphere(3))
    found = register(ring, ball, (), Control(), rematch=_none)
    assert found is not None
    assert found.glued
    assert OPENED in found.confidence.reasons
    assert not found.confidence.is_sure


def _none(ours: Shape, theirs: Shape) -> list[Points]:
    raise AssertionError("nothing was opened")
