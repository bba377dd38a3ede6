"""A match as a picture: both shapes, with corresponding points joined and in the same colour."""

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from scipy.sparse.csgraph import minimum_spanning_tree

from broker.contracts import View as Side
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh, vertex_normals
from solver.prototype import Prototype
from worker.pictures.canvas import FAINT, INK, new_figure, png, shortened
from worker.pictures.coloring import point_colors
from worker.pictures.hypothesis import Hypothesis
from worker.pictures.scene import Scene, match_scenes, prototype_scenes
from worker.pictures.visibility import hidden_points

_INCHES = 12.0, 7.2
_LONGEST_NAME = 40
"""Characters of a shortened name."""

_LIGHT: Final = np.array([-0.35, 0.55, 0.76])
"""Direction to the light: from the upper left, in front."""

_DOT = 0.7
"""Diameter of a point of a cloud, in mean distances of neighbours."""


def draw_match(
    source: TriangleMesh,
    target: TriangleMesh,
    answer: Hypothesis,
    names: tuple[str, str] = ("source", "target"),
    side: Side = "front",
) -> bytes:
    """Draw a match.

    Parameters
    ----------
    source, target
        The meshes X and Y, as uploaded.
    answer
        The match, or an alternative; its vertex numbers are the users' own.
    names
        Names of the shapes.
    side
        Side of the source from which both are seen.

    Returns
    -------
    PNG, the same for the same match.
    """
    left, right = match_scenes(source, target, answer, side)
    labels = [_mesh_label(name, mesh) for name, mesh in zip(names, (source, target), strict=True)]
    return _drawn(left, right, answer, labels)


def draw_prototype_match(
    prototype: Prototype,
    target: TriangleMesh,
    answer: Hypothesis,
    names: tuple[str, str] = ("prototype", "target"),
    side: Side = "front",
) -> bytes:
    """Draw a match whose source is a prototype, on the surface of its reference shape.

    Parameters
    ----------
    prototype
        The source.
    target
        The mesh Y, as uploaded.
    answer
        The match, or an alternative.
    names
        Names of the prototype and the target.
    side
        As for :func:`draw_match`.

    Returns
    -------
    PNG, the same for the same match.
    """
    left, right = prototype_scenes(prototype, target, answer, side)
    label = _label(names[0], len(prototype.positions), "points")
    return _drawn(left, right, answer, [label, _mesh_label(names[1], target)])


def _mesh_label(name: str, mesh: TriangleMesh) -> str:
    return _label(name, mesh.n_vertices, "points" if mesh.is_cloud else "vertices")


def _label(name: str, count: int, what: str) -> str:
    return f"{shortened(name, _LONGEST_NAME)}\n{count:,} {what}"


def _drawn(left: Scene, right: Scene, answer: Hypothesis, labels: list[str]) -> bytes:
    figure = new_figure(_INCHES)
    axes = figure.add_axes((0.02, 0.06, 0.96, 0.80))
    axes.set_axis_off()
    axes.set_aspect("equal")
    for scene in (left, right):
        if scene.is_cloud:
            _draw_cloud(axes, scene)
        elif len(scene.faces):
            draw_surface(axes, scene)
        else:
            _draw_skeleton(axes, scene)
    _draw_points(axes, left, right)
    for scene, label in zip((left, right), labels, strict=True):
        x, y = _middle(scene), float(scene.vertices[:, 1].min())
        axes.annotate(
            label.lstrip(), (x, y), (0, -10), textcoords="offset points", ha="center", va="top",
            fontsize=10, color=FAINT, linespacing=1.5, parse_math=False,
        )  # fmt: skip
    axes.autoscale_view()
    figure.text(0.5, 0.955, answer.title, ha="center", fontsize=14, color=INK)
    figure.text(
        0.5, 0.935, answer.subtitle, ha="center", va="top", fontsize=10, color=FAINT,
        linespacing=1.5, parse_math=False,
    )  # fmt: skip
    return png(figure)


def draw_surface(axes: Axes, scene: Scene) -> None:
    """Draw the triangles of a scene, from back to front."""
    corners = scene.vertices[scene.faces]
    order = np.argsort(corners[:, :, 2].mean(axis=1), kind="stable")
    shade = _shades(scene)[order]
    skin = scene.colors
    if skin.ndim == 2:
        skin = skin[scene.faces].mean(axis=1)[order]
    colors = np.clip(skin * shade[:, None], 0.0, 1.0)
    # The type of the argument is a sequence, but an array is taken faster.
    drawn: Any = corners[order][:, :, :2]
    # Edges in the face's own colour close the hairlines that antialiasing leaves between faces.
    axes.add_collection(PolyCollection(drawn, facecolors=colors, edgecolors=colors, linewidths=0.3))


def _draw_cloud(axes: Axes, scene: Scene) -> None:
    """Draw the points of a cloud, from back to front."""
    order = np.argsort(scene.vertices[:, 2], kind="stable")
    shade = np.zeros(len(order))
    np.maximum.at(shade, scene.faces, _shades(scene)[:, None])
    colors = np.clip(np.broadcast_to(scene.colors, scene.vertices.shape) * shade[:, None], 0.0, 1.0)
    # Of unit area: the mean distance of neighbours.
    widths = np.full(len(order), _DOT / np.sqrt(len(order)))
    places = scene.vertices[order, :2]
    axes.add_collection(
        EllipseCollection(
            widths, widths, np.zeros(len(order)), units="xy", offsets=places,
            offset_transform=axes.transData, facecolors=colors[order], linewidths=0.0,
        )
    )  # fmt: skip
    axes.update_datalim(places)


def _draw_skeleton(axes: Axes, scene: Scene) -> None:
    """Draw points without a surface, joined by their minimum spanning tree."""
    apart = np.linalg.norm(scene.vertices[:, None] - scene.vertices, axis=2)
    tree = minimum_spanning_tree(apart).tocoo()
    ends = scene.vertices[np.stack([tree.row, tree.col], axis=1)][:, :, :2]
    axes.add_collection(LineCollection(list(ends), colors=FAINT, linewidths=1.2, alpha=0.5))
    x, y = scene.vertices[:, 0], scene.vertices[:, 1]
    axes.scatter(x, y, s=14.0, c=FAINT, linewidths=0.0, zorder=2)


def _shades(scene: Scene) -> FloatArray:
    """(F,) brightness by smooth normals, turned towards the reader."""
    smooth = vertex_normals(scene.vertices, scene.faces)[scene.faces].sum(axis=1)
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1), 1e-300)[:, None]
    smooth *= np.where(smooth[:, 2] < 0.0, -1.0, 1.0)[:, None]
    lit = np.clip(smooth @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    shades: FloatArray = 0.62 + 0.46 * lit - 0.10 * (1.0 - smooth[:, 2]) ** 2
    return shades


def _draw_points(axes: Axes, left: Scene, right: Scene) -> None:
    here, there = left.points, right.points
    colors = point_colors(here)
    axes.add_collection(
        LineCollection(
            list(np.stack([here[:, :2], there[:, :2]], axis=1)),
            colors=colors, linewidths=0.9, alpha=0.45, zorder=3,
        )
    )  # fmt: skip
    for scene, places in ((left, here), (right, there)):
        hidden = hidden_points(scene.vertices, scene.faces, scene.points)
        for which, size, alpha in ((hidden, 26.0, 0.55), (~hidden, 52.0, 1.0)):
            axes.scatter(
                places[which, 0], places[which, 1], s=size, c=colors[which], alpha=alpha,
                edgecolors="white", linewidths=0.9, zorder=4,
            )  # fmt: skip


def _middle(scene: Scene) -> float:
    return float(0.5 * (scene.vertices[:, 0].min() + scene.vertices[:, 0].max()))
