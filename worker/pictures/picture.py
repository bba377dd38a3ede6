"""A match as a picture: both shapes, corresponding points in the same colour and joined."""

from dataclasses import dataclass, field, replace
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import hsv_to_rgb
from matplotlib.figure import Figure
from scipy.sparse.csgraph import minimum_spanning_tree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, vertex_normals
from worker.pictures.coloring import colors_by_place, colors_carried
from worker.pictures.hypothesis import Hypothesis
from worker.pictures.view import source_view, target_view

_SKIN = np.array([0.86, 0.87, 0.89])
_INK = "#2b2f36"
_FAINT = "#6b7280"
_INCHES = 12.0, 7.2
_DOTS_PER_INCH = 140
_GAP = 0.28
_LIGHT = np.array([-0.35, 0.55, 0.76])


@dataclass(frozen=True, eq=False)
class _Scene:
    """One shape as it lies on the paper: x to the right, y up, z towards the reader.

    Its surface has one colour, or one at each vertex.
    """

    vertices: FloatArray
    faces: IntArray
    points: FloatArray
    colors: FloatArray = field(default_factory=lambda: _SKIN)


def draw_match(
    source: TriangleMesh,
    target: TriangleMesh,
    answer: Hypothesis,
    names: tuple[str, str] = ("source", "target"),
) -> bytes:
    """Draw a match.

    Parameters
    ----------
    source, target
        The meshes X and Y, as uploaded.
    answer
        The match, or an alternative; its vertex numbers are the users' own.
    names
        What the shapes are called.

    Returns
    -------
    PNG, the same for the same match.
    """
    left, right = _scenes(source, target, answer)
    labels = [
        f"{_short(name)}\n{mesh.n_vertices:,} vertices"
        for name, mesh in zip(names, (source, target), strict=True)
    ]
    return _drawn(left, right, answer, labels)


def draw_prototype_match(
    positions: FloatArray,
    target: TriangleMesh,
    answer: Hypothesis,
    names: tuple[str, str] = ("prototype", "target"),
) -> bytes:
    """Draw a match whose source is a prototype: its points where they are on its reference shape.

    Parameters
    ----------
    positions
        (N, 3) the prototype's points there.
    target
        The mesh Y, as uploaded.
    answer
        The match, or an alternative.
    names
        What the two are called.

    Returns
    -------
    PNG, the same for the same match.
    """
    second = _unit(target)
    matched = np.array([pair.source for pair in answer.correspondences], dtype=np.int64)
    there = _target_points(target, second, answer)
    # The reference's size is not known: the points are drawn as large as those of the target.
    first = positions / max(float(np.abs(positions).max()), 1e-300)
    first = first - first.mean(axis=0)
    spread = np.linalg.norm(first) / np.sqrt(len(first))
    size = np.linalg.norm(there - there.mean(axis=0)) / np.sqrt(max(len(there), 1))
    first = first * (size / spread if size > 0.0 and spread > 1e-9 else 1.0)
    left, right = _beside(
        (first, np.zeros((0, 3), dtype=np.int64), first[matched]), (second, target.faces, there)
    )
    labels = [f"{_short(names[0])}\n{len(positions):,} points"]
    labels.append(f"{_short(names[1])}\n{target.n_vertices:,} vertices")
    return _drawn(left, right, answer, labels)


def _drawn(left: _Scene, right: _Scene, answer: Hypothesis, labels: list[str]) -> bytes:
    figure = Figure(figsize=_INCHES, dpi=_DOTS_PER_INCH, facecolor="white")
    axes = figure.add_axes((0.02, 0.06, 0.96, 0.82))
    axes.set_axis_off()
    axes.set_aspect("equal")
    for scene in (left, right):
        if len(scene.faces):
            _draw_surface(axes, scene)
        else:
            _draw_skeleton(axes, scene)
    _draw_points(axes, left, right)
    for scene, label in zip((left, right), labels, strict=True):
        x, y = _middle(scene), float(scene.vertices[:, 1].min())
        axes.annotate(
            label.lstrip(), (x, y), (0, -10), textcoords="offset points", ha="center", va="top",
            fontsize=10, color=_FAINT, linespacing=1.5, parse_math=False,
        )  # fmt: skip
    axes.autoscale_view()
    figure.text(0.5, 0.955, answer.title, ha="center", fontsize=14, color=_INK)
    figure.text(0.5, 0.915, answer.subtitle, ha="center", fontsize=10, color=_FAINT)
    canvas = FigureCanvasAgg(figure)
    png = BytesIO()
    canvas.print_figure(png, format="png", dpi=_DOTS_PER_INCH, metadata={"Software": "isomatch"})
    return png.getvalue()


def _scenes(
    source: TriangleMesh, target: TriangleMesh, answer: Hypothesis
) -> tuple[_Scene, _Scene]:
    """Both shapes, turned alike, of the same area, standing side by side."""
    first = _unit(source)
    second = _unit(target)
    numbers = np.array([pair.source for pair in answer.correspondences], dtype=np.int64)
    here = first[source.vertices_of(numbers)]
    there = _target_points(target, second, answer)
    left, right = _beside((first, source.faces, here), (second, target.faces, there))
    if answer.dense is None:
        return left, right
    colors = colors_by_place(left.vertices)
    carried = colors_carried(colors, source, target, answer.dense)
    return replace(left, colors=colors), replace(right, colors=carried)


def _beside(
    source: tuple[FloatArray, IntArray, FloatArray],
    target: tuple[FloatArray, IntArray, FloatArray],
) -> tuple[_Scene, _Scene]:
    """Vertices, faces and points of both, turned alike and put side by side."""
    (first, first_faces, here), (second, second_faces, there) = source, target
    view = source_view(first)
    left = view.of(first)
    other = target_view(view, here, there) if len(here) >= 3 else view
    right = other.of(second)
    to_left = np.array([left[:, 0].max() + _GAP, left[:, 1].min(), 0.0])
    to_right = np.array([right[:, 0].min() - _GAP, right[:, 1].min(), 0.0])
    return (
        _Scene(left - to_left, first_faces, view.of(here) - to_left),
        _Scene(right - to_right, second_faces, other.of(there) - to_right),
    )


def _target_points(target: TriangleMesh, vertices: FloatArray, answer: Hypothesis) -> FloatArray:
    """(K, 3) where the matched points lie on the target: between its vertices, if known so."""
    if answer.refinement is None:
        numbers = np.array([pair.target for pair in answer.correspondences], dtype=np.int64)
        return vertices[target.vertices_of(numbers)]
    refined = answer.refinement.points
    corners = np.array([point.vertices for point in refined], dtype=np.int64)
    weights = np.array([point.weights for point in refined])
    places: FloatArray = np.einsum("kc,kcd->kd", weights, vertices[target.vertices_of(corners)])
    return places


def _unit(mesh: TriangleMesh) -> FloatArray:
    return mesh.scaled(1.0 / np.sqrt(mesh.area)).vertices


def _draw_surface(axes: Axes, scene: _Scene) -> None:
    corners = scene.vertices[scene.faces]
    order = np.argsort(corners[:, :, 2].mean(axis=1), kind="stable")
    shade = _shades(scene)[order]
    skin = scene.colors
    if skin.ndim == 2:
        skin = skin[scene.faces].mean(axis=1)[order]
    colors = np.clip(skin * shade[:, None], 0.0, 1.0)
    # Edges in the face's own colour close the hairlines that antialiasing leaves between faces.
    axes.add_collection(
        PolyCollection(
            list(corners[order][:, :, :2]), facecolors=colors, edgecolors=colors, linewidths=0.3
        )
    )


def _draw_skeleton(axes: Axes, scene: _Scene) -> None:
    """Points without a surface, and the shortest lines that join all of them."""
    apart = np.linalg.norm(scene.vertices[:, None] - scene.vertices, axis=2)
    tree = minimum_spanning_tree(apart).tocoo()
    ends = scene.vertices[np.stack([tree.row, tree.col], axis=1)][:, :, :2]
    axes.add_collection(LineCollection(list(ends), colors=_FAINT, linewidths=1.2, alpha=0.5))
    x, y = scene.vertices[:, 0], scene.vertices[:, 1]
    axes.scatter(x, y, s=14.0, c=_FAINT, linewidths=0.0, zorder=2)


def _shades(scene: _Scene) -> FloatArray:
    """(F,) brightness: smooth normals, lit from the upper left, from both sides alike."""
    smooth = vertex_normals(scene.vertices, scene.faces)[scene.faces].sum(axis=1)
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1), 1e-300)[:, None]
    smooth *= np.where(smooth[:, 2] < 0.0, -1.0, 1.0)[:, None]
    lit = np.clip(smooth @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    shades: FloatArray = 0.62 + 0.46 * lit - 0.10 * (1.0 - smooth[:, 2]) ** 2
    return shades


def _draw_points(axes: Axes, left: _Scene, right: _Scene) -> None:
    here, there = left.points, right.points
    colors = _colors(here)
    axes.add_collection(
        LineCollection(
            list(np.stack([here[:, :2], there[:, :2]], axis=1)),
            colors=colors, linewidths=0.9, alpha=0.45, zorder=3,
        )
    )  # fmt: skip
    for scene, places in ((left, here), (right, there)):
        hidden = _hidden(scene)
        for which, size, alpha in ((hidden, 26.0, 0.55), (~hidden, 52.0, 1.0)):
            axes.scatter(
                places[which, 0], places[which, 1], s=size, c=colors[which], alpha=alpha,
                edgecolors="white", linewidths=0.9, zorder=4,
            )  # fmt: skip


def _colors(places: FloatArray) -> FloatArray:
    """(K, 3) hue by direction from the middle, paler near it: neighbours have like colours."""
    offsets = places[:, :2] - 0.5 * (
        places[:, :2].min(axis=0, initial=np.inf) + places[:, :2].max(axis=0, initial=-np.inf)
    )
    hue = (np.arctan2(offsets[:, 1], offsets[:, 0]) / (2.0 * np.pi)) % 1.0
    reach = np.linalg.norm(offsets, axis=1)
    saturation = 0.55 + 0.40 * reach / max(float(reach.max(initial=0.0)), 1e-300)
    return np.asarray(hsv_to_rgb(np.stack([hue, saturation, np.full_like(hue, 0.88)], axis=1)))


def _hidden(scene: _Scene) -> BoolArray:
    """(K,) whether some face lies clearly in front of a point."""
    a, b, c = np.moveaxis(scene.vertices[scene.faces], 1, 0)
    tolerance = 0.02
    hidden = np.zeros(len(scene.points), dtype=np.bool_)
    ab, ac = b - a, c - a
    twice = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    sound = np.abs(twice) > 1e-18
    for i, place in enumerate(scene.points):
        ap = place - a
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (ap[:, 0] * ac[:, 1] - ap[:, 1] * ac[:, 0]) / twice
            v = (ab[:, 0] * ap[:, 1] - ab[:, 1] * ap[:, 0]) / twice
            inside = sound & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
            depth = a[:, 2] + u * ab[:, 2] + v * ac[:, 2]
            hidden[i] = bool((inside & (depth > place[2] + tolerance)).any())
    return hidden


def _middle(scene: _Scene) -> float:
    return float(0.5 * (scene.vertices[:, 0].min() + scene.vertices[:, 0].max()))


def _short(name: str) -> str:
    return name if len(name) <= 40 else name[:37] + "..."
