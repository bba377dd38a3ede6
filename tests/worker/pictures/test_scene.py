"""Shapes of a match in the coordinates of a picture."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from broker.contracts import (
    Correspondence,
    DenseCorrespondence,
    InverseCorrespondence,
    Refinement,
)
from solver.mesh import TriangleMesh, triangle_mesh
from solver.prototype import Prototype, PrototypeOptions, connected_examples, learn_prototype
from solver.shape import Shape
from synthetic import HUMAN_POSES, human
from tests.solver import shapes
from worker.pictures import draw_match, draw_prototype_match, match_picture
from worker.pictures.coloring import UNMAPPED
from worker.pictures.hypothesis import Hypothesis
from worker.pictures.scene import match_scenes, prototype_scenes


@cache
def learned() -> tuple[TriangleMesh, Prototype]:
    """A shape, and a prototype of it alone."""
    body = human(next(iter(HUMAN_POSES)), resolution=400)
    mesh = triangle_mesh(body.vertices, body.faces)
    options = PrototypeOptions(points=8, components=1)
    return mesh, learn_prototype(connected_examples((Shape(mesh),), options).examples, options)


def test_a_prototype_is_drawn_on_its_reference_surface() -> None:
    """Matched with the shape it was learned from: both are drawn alike."""
    mesh, prototype = learned()
    pairs = tuple(
        Correspondence(source=point, target=vertex, cost=0.0)
        for point, vertex in enumerate(prototype.vertices.tolist())
    )
    answer = Hypothesis(pairs, None, None, "", "")
    for kept, rough in ((prototype, 0.05), (replace(prototype, surfaces=()), 1e-9)):
        left, right = prototype_scenes(kept, mesh, answer)
        assert (len(left.faces) > 0) == (kept is prototype)
        np.testing.assert_allclose(pdist(left.points), pdist(right.points), atol=rough)
        assert left.vertices[:, 0].max() < right.vertices[:, 0].min()
    assert float(np.ptp(left.points[:, 1])) == pytest.approx(float(np.ptp(right.points[:, 1])))


def test_vertices_without_a_partner_are_grey_on_both_shapes() -> None:
    """A surface that overlaps itself in all but one vertex on either side."""
    mesh = shapes.blob(2)
    ours, theirs = np.arange(1, mesh.n_vertices), np.arange(mesh.n_vertices - 1)
    weights = ((1.0, 0.0, 0.0),) * len(ours)
    inverse = InverseCorrespondence(
        target=tuple(theirs.tolist()),
        source=tuple(theirs.tolist()),
        faces=tuple((one, one, one) for one in theirs.tolist()),
        barycentric=weights,
    )
    dense = DenseCorrespondence(
        hypothesis=0, source=tuple(ours.tolist()), target=tuple(ours.tolist()), inverse=inverse
    )
    pairs = tuple(Correspondence(source=one, target=one, cost=0.0) for one in (3, 7, 30))
    left, right = match_scenes(mesh, mesh, Hypothesis(pairs, None, dense, "", ""))
    grey = [
        np.flatnonzero((scene.colors == UNMAPPED).all(axis=1)).tolist() for scene in (left, right)
    ]
    assert grey == [[0], [mesh.n_vertices - 1]]


def test_a_refined_match_without_pairs_is_drawn() -> None:
    refinement = Refinement(
        hypothesis=0, stress=0.0, initial_stress=0.0, status="converged", points=()
    )
    mesh = shapes.blob(1)
    answer = Hypothesis((), refinement, None, "", "")
    for scene in match_scenes(mesh, mesh, answer):
        assert scene.points.shape == (0, 3)
    assert draw_match(mesh, mesh, answer).startswith(b"\x89PNG")


def test_a_cloud_is_labelled_by_its_points(monkeypatch: pytest.MonkeyPatch) -> None:
    labels: list[list[str]] = []

    def drawn(*given: Any) -> bytes:
        labels.append([label.replace("\n", " ") for label in given[-1]])
        return b""

    monkeypatch.setattr(match_picture, "_drawn", drawn)
    mesh, prototype = learned()
    cloud = replace(mesh, is_cloud=True)
    pairs = tuple(Correspondence(source=one, target=one, cost=0.0) for one in range(8))
    answer = Hypothesis(pairs, None, None, "", "")
    count = f"{mesh.n_vertices:,}"
    draw_prototype_match(prototype, cloud, answer)
    draw_match(mesh, cloud, answer)
    assert labels == [
        ["prototype 8 points", f"target {count} points"],
        [f"source {count} vertices", f"target {count} points"],
    ]
