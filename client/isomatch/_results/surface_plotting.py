"""Shapes in three dimensions, side by side, by matplotlib."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from isomatch._results.plotting import FAINT, new_figure
from isomatch._results.view import View, own_view, turned_alike

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]

_SKIN: Final = 0.9
_SEEN_THROUGH: Final = 0.45
_PALE: Final = 0.4
_LIGHT: Final = np.array([-0.35, 0.55, 0.76]) / np.linalg.norm([-0.35, 0.55, 0.76])
_INCHES: Final = 5.5


NO_FACES: Final[Places] = np.zeros((0, 3), dtype=np.int64)
NO_BONES: Final[Floats] = np.zeros((0, 2, 3))


@dataclass(frozen=True, eq=False)
class Scene:
    """What is drawn of one shape.

    Parameters
    ----------
    vertices
        (V, 3) all that must be in sight.
    points
        (n, 3) points that stand out.
    faces
        (F, 3) rows of `vertices`; none where no surface is known.
    colors
        (V, 3) of the surface, 0 to 1; None to see the points through it.
    bones, bone_colors
        (m, 2, 3) ends of lines, and (m, 3) colours of these if they have their own.
    caption
        Goes below.
    """

    vertices: Floats
    points: Floats
    faces: Places = field(default_factory=lambda: NO_FACES)
    colors: Floats | None = None
    bones: Floats = field(default_factory=lambda: NO_BONES)
    bone_colors: Floats | None = None
    caption: str = ""

    @property
    def view(self) -> View:
        """From where it is looked at by itself."""
        return own_view(self.vertices[np.unique(self.faces)] if len(self.faces) else self.vertices)


def plot_scenes(scenes: Sequence[Scene], title: str) -> "Figure":
    """Draw shapes side by side, corresponding points in common colours.

    Parameters
    ----------
    scenes
        The shapes: one row of all their points is a point and its correspondents. The colours
        tell where the last has them; all but the first are turned until they lie alike.
    title
        Goes above.
    """
    figure = new_figure(_INCHES * len(scenes), _INCHES)
    colors = place_colors(scenes[-1].points, scenes[-1].vertices)
    first = scenes[0].view
    for place, scene in enumerate(scenes, start=1):
        # Its type is that of flat axes.
        axes: Any = figure.add_subplot(1, len(scenes), place, projection="3d")
        view = turned_alike(first, scene.view, scenes[0].points, scene.points)
        draw_scene(axes, scene, colors, first if place == 1 else view)
    figure.suptitle(title, parse_math=False)
    return figure


def draw_scene(axes: Any, scene: Scene, colors: Floats, view: View) -> None:
    """Draw a shape.

    Parameters
    ----------
    axes
        Of three dimensions.
    scene
        The shape.
    colors
        (n, 3) of its points.
    view
        From where it is seen first.
    """
    # No point is hidden behind the surface: it would be nowhere if the figure is not turned.
    axes.computed_zorder = False
    if len(scene.faces):
        axes.add_collection3d(_skin(scene, view))
    if len(scene.bones):
        axes.add_collection3d(_bones(scene))
    size = 42 if scene.colors is None else 22
    axes.scatter(
        *scene.points.T, c=colors, s=size, depthshade=False, edgecolors="black", linewidths=0.6,
        zorder=3,
    )  # fmt: skip
    middle, reach = _box(scene)
    for name, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{name}lim")(centre - reach, centre + reach)
    axes.set_box_aspect((1.0, 1.0, 1.0), zoom=1.5)
    axes.view_init(elev=6.0, azim=view.azimuth, vertical_axis="xyz"[view.up])
    axes.set_axis_off()
    if scene.caption:
        axes.text2D(
            0.5, 0.02, scene.caption, transform=axes.transAxes, ha="center", color=FAINT,
            parse_math=False,
        )  # fmt: skip


def place_colors(points: Floats, shape: Floats) -> Floats:
    """Colours of points, (n, 3) between 0 and 1, alike for those that are near one another.

    Parameters
    ----------
    points
        (n, 3).
    shape
        (V, 3) points of the shape that they are on; where all of these are, is what they span.
    """
    if not len(points):
        return np.zeros((0, 3))
    lowest, size = shape.min(axis=0), np.ptp(shape, axis=0)
    shares = np.clip((points - lowest) / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
    colors: Floats = 0.08 + 0.84 * shares
    return colors


def surface_colors(vertices: Floats) -> Floats:
    """Colours of a surface's vertices, (V, 3): paler than those of points upon it."""
    pale: Floats = _PALE + (1.0 - _PALE) * place_colors(vertices, vertices)
    return pale


def _skin(scene: Scene, view: View) -> Any:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = scene.vertices[scene.faces]
    shade = _brightness(scene, view)[:, None]
    if scene.colors is None:
        gray = np.repeat(np.clip(_SKIN * shade, 0.0, 1.0), 3, axis=1)
        colors = np.column_stack([gray, np.full(len(gray), _SEEN_THROUGH)])
        return Poly3DCollection(corners, facecolors=colors)
    colors = np.clip(scene.colors[scene.faces].mean(axis=1) * shade, 0.0, 1.0)
    # Edges in the face's own colour close the hairlines that antialiasing leaves between faces.
    return Poly3DCollection(corners, facecolors=colors, edgecolors=colors, linewidths=0.3)


def _bones(scene: Scene) -> Any:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    colors = FAINT if scene.bone_colors is None else scene.bone_colors
    width = 1.4 if scene.bone_colors is None else 3.5
    return Line3DCollection(scene.bones, colors=colors, linewidths=width, zorder=2)


def _brightness(scene: Scene, view: View) -> Floats:
    """(F,) of the triangles, with smooth normals, lit from the upper left."""
    corners = scene.vertices[scene.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros_like(scene.vertices)
    for corner in range(3):
        np.add.at(sums, scene.faces[:, corner], across)
    normals = sums[scene.faces].sum(axis=1) @ view.axes.T
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0.0, lengths, 1.0)
    # Surfaces may be wound either way: both sides are lit alike.
    normals *= np.where(normals[:, 2:] < 0.0, -1.0, 1.0)
    shade: Floats = 0.6 + 0.45 * np.clip(normals @ _LIGHT, 0.0, 1.0)
    return shade


def _box(scene: Scene) -> tuple[Floats, float]:
    used = scene.vertices[np.unique(scene.faces)] if len(scene.faces) else scene.vertices
    lowest, highest = used.min(axis=0), used.max(axis=0)
    return 0.5 * (lowest + highest), 0.5 * float((highest - lowest).max()) or 1.0
