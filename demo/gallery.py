"""Run docs/gallery.md and draw its pictures: ``make gallery``."""

import contextlib
import os
import re
import runpy
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from isomatch import read_landmarks
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from demo.gallery_shapes import write_files
from demo.stack import ROOT, running_stack
from solver.arrays import FloatArray, IntArray

DOCS: Final = ROOT / "docs"
_CODE: Final = re.compile(r"(?ms)^```python\n(.*?)^```$")

_PALETTE: Final = np.array(
    [
        [0.85, 0.37, 0.01],
        [0.46, 0.44, 0.70],
        [0.11, 0.62, 0.47],
        [0.91, 0.54, 0.76],
        [0.90, 0.67, 0.01],
    ]
)
_GREY: Final = np.array([0.82, 0.83, 0.85])
_LIGHT: Final = np.array([-0.36, 0.56, 0.75])


@dataclass(frozen=True, eq=False)
class Panel:
    """A shape as it is drawn, seen along z with y up.

    Attributes
    ----------
    vertices, faces
        (V, 3) and (F, 3).
    colors
        (V, 3), 0 to 1.
    points
        (n, 3), drawn on it in the order of the palette's colours.
    """

    vertices: FloatArray
    faces: IntArray
    colors: FloatArray
    points: FloatArray


def main() -> int:
    """Write the pictures into docs/."""
    with tempfile.TemporaryDirectory() as name, running_stack() as stack:
        os.environ["ISOMATCH_URL"] = stack.url
        write_files(Path(name))
        with contextlib.chdir(name):
            draw_pictures(run(DOCS / "gallery.md"))
    return 0


def run(document: Path) -> dict[str, Any]:
    """Run the Python blocks of a document in the current folder, and return their variables."""
    script = Path("gallery.py")
    script.write_text("".join(_CODE.findall(document.read_text(encoding="utf-8"))))
    return runpy.run_path(str(script))


def draw_pictures(variables: dict[str, Any]) -> None:
    """Draw what the tasks have left in the current folder."""
    client = variables["client"]
    here, there = (client.geometry(variables[name]) for name in ("dressed", "walking"))
    nothing = np.empty((0, 3))

    def both(name: str, colors: Sequence[FloatArray], points: Sequence[FloatArray]) -> None:
        panels = [
            Panel(one.vertices, one.faces, color[one.vertex_ids], marks)
            for one, color, marks in zip((here, there), colors, points, strict=True)
        ]
        draw(DOCS / f"gallery-{name}.png", panels)

    given = np.loadtxt("parts.csv", dtype=str, skiprows=1)
    carried = np.loadtxt("walking-parts.csv", dtype=str, delimiter=",", skiprows=1)[:, 1]
    names = np.unique(given)
    parts = [_PALETTE[np.searchsorted(names, labels)] for labels in (given, carried)]
    both("parts", parts, (nothing, nothing))

    grey = [np.tile(_GREY, (len(labels), 1)) for labels in (given, carried)]
    landmarks = [read_landmarks(f"{name}.mrk.json")[0] for name in ("dressed", "human-walking")]
    both("landmarks", grey, [one.positions for one in landmarks])

    variables["texture"].save("texture.npz")
    with np.load("texture.npz") as arrays:
        texture = arrays["colors"]
    assert here.colors is not None
    own = np.zeros((len(given), 3))
    own[here.vertex_ids] = here.colors / 255.0
    both("texture", [own, texture], (nothing, nothing))
    for drawn in ("dissimilarities", "mean"):
        (DOCS / f"gallery-{drawn}.png").write_bytes(Path(f"{drawn}.png").read_bytes())


def draw(path: Path, panels: Sequence[Panel]) -> None:
    """Draw shapes beside one another, far triangles first."""
    figure = Figure(figsize=(2.2 * len(panels), 3.8), dpi=110)
    FigureCanvasAgg(figure)
    for place, panel in enumerate(panels):
        axes = figure.add_axes((place / len(panels), 0.0, 1.0 / len(panels), 1.0))
        corners = panel.vertices[panel.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        light = 0.6 + 0.4 * (normals @ _LIGHT).clip(0.0)
        order = corners[:, :, 2].mean(axis=1).argsort()
        shades = (light[:, None] * panel.colors[panel.faces].mean(axis=1))[order].clip(0.0, 1.0)
        axes.add_collection(
            PolyCollection(
                list(corners[order, :, :2]), facecolors=shades, edgecolors=shades, linewidths=0.4
            )
        )
        dots = np.resize(_PALETTE, (len(panel.points), 3))
        axes.scatter(
            panel.points[:, 0], panel.points[:, 1], s=55, c=dots, edgecolors="white", zorder=3
        )
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.axis("off")
    figure.savefig(path)


if __name__ == "__main__":
    sys.exit(main())
