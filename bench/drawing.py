"""Pictures of experiments: two shapes side by side, corresponding points joined."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh
from worker.pictures import View, source_view

_SKIN = np.array([0.80, 0.83, 0.88])
_LIGHT = np.array([-0.37, 0.57, 0.73])
_RIGHT, _WRONG = "#1f6fb2", "#d1362f"
_GAP = 0.25


@dataclass(frozen=True, eq=False)
class Matched:
    """Two shapes and points that were matched.

    Attributes
    ----------
    source, target
        The meshes, drawn to the same scale.
    here, there
        (K,) int64, matched vertices.
    right
        (K,) bool, whether the match is.
    """

    source: TriangleMesh
    target: TriangleMesh
    here: IntArray
    there: IntArray
    right: BoolArray


def draw_pair(axes: Axes, matched: Matched, colored: bool = False) -> None:
    """Draw two shapes beside one another, their matched points joined, wrong ones in red.

    Parameters
    ----------
    axes
        Where.
    matched
        What; both shapes are seen from the side from which the source looks widest.
    colored
        Whether the meshes, which must have colours then, are drawn in them.
    """
    source = matched.source
    view = source_view(source.vertices - source.vertices.mean(axis=0), source.faces)
    left, right = _seen(view, matched.source), _seen(view, matched.target)
    left[:, 0] -= left[:, 0].max() + 0.5 * _GAP
    right[:, 0] += 0.5 * _GAP - right[:, 0].min()
    for places, mesh in ((left, matched.source), (right, matched.target)):
        skin = _SKIN
        if colored:
            assert mesh.colors is not None
            skin = mesh.colors[mesh.faces].mean(axis=1)
        _draw_surface(axes, places, mesh.faces, skin)
    ends = np.stack([left[matched.here, :2], right[matched.there, :2]], axis=1)
    colors = [_RIGHT if right else _WRONG for right in matched.right]
    axes.add_collection(LineCollection(list(ends), colors=colors, linewidths=0.8, alpha=0.7))
    for side in (0, 1):
        x, y = ends[:, side, 0], ends[:, side, 1]
        axes.scatter(x, y, s=14.0, c=colors, edgecolors="white", linewidths=0.5, zorder=4)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()


def save(figure: Figure, path: Path) -> None:
    """Write a picture to a PNG file."""
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    FigureCanvasAgg(figure).print_figure(str(path), format="png")


def _seen(view: View, mesh: TriangleMesh) -> FloatArray:
    """(V, 3) places on the paper, standing on the line y = 0."""
    places = view.of(mesh.vertices - mesh.vertices.mean(axis=0))
    places[:, 1] -= places[:, 1].min()
    return places


def _draw_surface(axes: Axes, places: FloatArray, faces: IntArray, skin: FloatArray) -> None:
    corners = places[faces]
    order = np.argsort(corners[:, :, 2].mean(axis=1), kind="stable")
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
    shade = 0.6 + 0.4 * np.clip(normals @ _LIGHT, 0.0, 1.0)
    colors = (shade[:, None] * skin)[order]
    axes.add_collection(
        PolyCollection(
            list(corners[order][:, :, :2]), facecolors=colors, edgecolors=colors, linewidths=0.2
        )
    )
