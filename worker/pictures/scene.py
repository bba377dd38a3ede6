"""Shapes of a match in the coordinates of the paper, side by side, with their matched points."""

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from broker.contracts import View as Side
from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.prototype import Prototype
from worker.pictures.coloring import UNMAPPED, surface_colors, transferred_colors
from worker.pictures.hypothesis import Hypothesis
from worker.pictures.view import source_view, target_view

GREY: Final = np.array([0.86, 0.87, 0.89])
"""Colour of surfaces without colours of their own."""

_GAP: Final = 0.28
"""From each shape to the middle of the picture, in units of the root of its area."""


@dataclass(frozen=True, eq=False)
class Scene:
    """One shape on the paper: x to the right, y up, z towards the reader.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (F, 3); without faces, a set of points is drawn.
    points
        (K, 3) the matched points.
    colors
        (3,) colour of the surface, or (V, 3) colours of its vertices.
    is_cloud
        Whether the vertices are drawn instead of the faces, which were made of them.
    """

    vertices: FloatArray
    faces: IntArray
    points: FloatArray
    colors: FloatArray = field(default_factory=lambda: GREY)
    is_cloud: bool = False


def match_scenes(
    source: TriangleMesh, target: TriangleMesh, answer: Hypothesis, side: Side = "front"
) -> tuple[Scene, Scene]:
    """Return both shapes of a match, scaled to unit area and with matched points aligned.

    Colours show a map of all vertices: places on the source have the colours of matched points
    there, and those on the target have the colours of their points on the source. Vertices without
    a partner are grey on either.
    """
    first, second = _unit_area(source), _unit_area(target)
    numbers = np.array([pair.source for pair in answer.correspondences], dtype=np.int64)
    points = first[source.vertices_of(numbers)]
    left, right = _side_by_side(
        Scene(first, source.faces, points, is_cloud=source.is_cloud),
        Scene(
            second,
            target.faces,
            _target_points(target, second, answer),
            is_cloud=target.is_cloud,
        ),
        side,
    )
    if answer.dense is None or answer.dense.inverse is None:
        return left, right
    colors = surface_colors(left.vertices, left.points)
    transferred = transferred_colors(colors, source, target, answer.dense.inverse)
    mapped = source.vertices_of(np.array(answer.dense.source, dtype=np.int64))
    kept = np.full_like(colors, UNMAPPED)
    kept[mapped] = colors[mapped]
    return replace(left, colors=kept), replace(right, colors=transferred)


def prototype_scenes(
    prototype: Prototype, target: TriangleMesh, answer: Hypothesis, side: Side = "front"
) -> tuple[Scene, Scene]:
    """Return a prototype and the target.

    A prototype is drawn as the surface of its reference shape, or, if it was stored without, as its
    points, scaled as those matched on the target.

    Parameters
    ----------
    prototype
        The source.
    target
        The mesh Y.
    answer
        The match, or an alternative.
    side
        Side of the source from which both are seen.
    """
    vertices = _unit_area(target)
    matched = np.array([pair.source for pair in answer.correspondences], dtype=np.int64)
    there = _target_points(target, vertices, answer)
    right = Scene(vertices, target.faces, there, is_cloud=target.is_cloud)
    if prototype.surfaces:
        reference = prototype.surfaces[0]
        surface = _unit_area(reference.mesh())
        points = surface[reference.points[matched]]
        return _side_by_side(Scene(surface, reference.faces, points), right, side)
    positions = prototype.positions
    points = positions / max(float(np.abs(positions).max()), 1e-300)
    points = points - points.mean(axis=0)
    spread = np.linalg.norm(points) / np.sqrt(len(points))
    size = np.linalg.norm(there - there.mean(axis=0)) / np.sqrt(max(len(there), 1))
    points = points * (size / spread if size > 0.0 and spread > 1e-9 else 1.0)
    return _side_by_side(
        Scene(points, np.zeros((0, 3), dtype=np.int64), points[matched]), right, side
    )


def _side_by_side(source: Scene, target: Scene, side: Side) -> tuple[Scene, Scene]:
    """Rotate both into their views, and move them to the two sides of the origin."""
    front = source_view(source.vertices, source.faces)
    aligned = target_view(front, source.points, target.points) if len(source.points) >= 3 else front
    view, other = front.seen_from(side), aligned.seen_from(side)
    left, right = view.of(source.vertices), other.of(target.vertices)
    to_left = np.array([left[:, 0].max() + _GAP, left[:, 1].min(), 0.0])
    to_right = np.array([right[:, 0].min() - _GAP, right[:, 1].min(), 0.0])
    return (
        replace(source, vertices=left - to_left, points=view.of(source.points) - to_left),
        replace(target, vertices=right - to_right, points=other.of(target.points) - to_right),
    )


def _target_points(target: TriangleMesh, vertices: FloatArray, answer: Hypothesis) -> FloatArray:
    """(K, 3) matched points on the target: refined ones between vertices, if there are any."""
    if answer.refinement is None:
        numbers = np.array([pair.target for pair in answer.correspondences], dtype=np.int64)
        return vertices[target.vertices_of(numbers)]
    refined = answer.refinement.points
    corners = np.array([point.vertices for point in refined], dtype=np.int64).reshape(-1, 3)
    weights = np.array([point.weights for point in refined], dtype=np.float64).reshape(-1, 3)
    places: FloatArray = np.einsum("kc,kcd->kd", weights, vertices[target.vertices_of(corners)])
    return places


def _unit_area(mesh: TriangleMesh) -> FloatArray:
    return mesh.scaled(1.0 / np.sqrt(mesh.area)).vertices
