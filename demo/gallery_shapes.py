"""Generate the files of docs/gallery.md: ``python -m demo.gallery_shapes FOLDER``."""

import argparse
import io
import zipfile
from pathlib import Path
from typing import Final

import numpy as np
from isomatch import LandmarkSet, write_landmarks
from PIL import Image

from demo.figures import write_off
from solver.arrays import FloatArray
from synthetic import SyntheticShape, articulated, clothed, human

ANIMALS: Final = (
    ("cat", "standing"),
    ("cat", "sitting"),
    ("horse", "standing"),
    ("horse", "galloping"),
)
POSES: Final = ("standing", "walking", "reaching", "sitting")
"""Of the person; these files share their triangles."""

PIXELS: Final = 192
"""Of the texture, in both directions: the front of the person, and beside it the back."""

MATERIAL: Final = "newmtl cloth\nmap_Kd cloth.png\n"

LANDMARKS: Final = {
    "top of the head": (0.0, 9.0, 0.0),
    "left hand": (9.0, 0.0, 0.0),
    "right hand": (-9.0, 0.0, 0.0),
    "left foot": (0.2, -9.0, 0.5),
    "right foot": (-0.2, -9.0, 0.5),
}
"""Directions in which these are the extreme points of the resting body."""


def write_files(folder: Path) -> None:
    """Write the files.

    Parameters
    ----------
    folder
        Where; it exists.
    """
    dressed = human("standing", resolution=900, seed=0)
    (folder / "dressed.zip").write_bytes(_textured(dressed))
    (folder / "parts.csv").write_text("\n".join(["part", *_parts(dressed.rest)]) + "\n")
    places = [int((dressed.rest @ np.array(towards)).argmax()) for towards in LANDMARKS.values()]
    landmarks = LandmarkSet(tuple(LANDMARKS), dressed.vertices[places], "dressed")
    write_landmarks(folder / "dressed.mrk.json", [landmarks])
    for pose in POSES:
        write_off(folder / f"human-{pose}.off", human(pose, resolution=700, seed=1))
    for number, (category, pose) in enumerate(ANIMALS):
        write_off(folder / f"{category}-{pose}.off", articulated(category, pose, 500, number))


def _parts(rest: FloatArray) -> list[str]:
    """Part of the body of each vertex, by its place at rest, with the arms stretched out."""
    low, high = rest[:, 1].min(), rest[:, 1].max()
    height = (rest[:, 1] - low) / (high - low)
    beside = np.abs(rest[:, 0]) / (high - low)
    parts = np.select(
        [height > 0.86, beside > 0.14, height < 0.47],
        ["head", "arms", "legs"],
        "trunk",
    )
    return [str(part) for part in parts]


def _textured(shape: SyntheticShape) -> bytes:
    """OBJ file with its material and texture, in a zip archive."""
    corners = shape.rest[shape.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    back = normals[:, 2] < 0.0
    low, size = shape.rest.min(axis=0), np.ptp(shape.rest, axis=0).max()
    flat = (shape.rest[:, :2] - low[:2]) / size
    # Two islands beside one another; a vertex at their border is in both.
    islands = np.concatenate([flat * [0.5, 1.0], flat * [0.5, 1.0] + [0.5, 0.0]])
    texture = shape.faces + len(flat) * back[:, None]
    lines = ["mtllib cloth.mtl", "usemtl cloth"]
    lines += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in shape.vertices.tolist()]
    lines += [f"vt {u:.6g} {v:.6g}" for u, v in islands.tolist()]
    pairs = zip((shape.faces + 1).tolist(), (texture + 1).tolist(), strict=True)
    lines += ["f " + " ".join(f"{v}/{t}" for v, t in zip(*pair, strict=True)) for pair in pairs]
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("dressed.obj", "\n".join(lines) + "\n")
        archive.writestr("cloth.mtl", MATERIAL)
        archive.writestr("cloth.png", _cloth(shape.rest, low, float(size)))
    return packed.getvalue()


def _cloth(rest: FloatArray, low: FloatArray, size: float) -> bytes:
    """The texture, PNG: the colours of the resting body seen from both sides."""
    across, up = np.meshgrid(np.arange(PIXELS) / PIXELS, 1.0 - np.arange(PIXELS) / PIXELS)
    depth = np.where(across < 0.5, rest[:, 2].max(), rest[:, 2].min())
    x = low[0] + size * (2.0 * across % 1.0)
    places = np.stack([x, low[1] + size * up, depth], axis=-1)
    # The extreme points fix the middle by which the cloths are told apart.
    points = np.concatenate([places.reshape(-1, 3), rest])
    colors = clothed(points)[: PIXELS * PIXELS].reshape(PIXELS, PIXELS, 3)
    out = io.BytesIO()
    Image.fromarray(np.rint(255.0 * colors).astype(np.uint8)).save(out, "PNG")
    return out.getvalue()


def main() -> None:
    """Write the files into the folder of the command line."""
    parser = argparse.ArgumentParser(prog="python -m demo.gallery_shapes", description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    folder.mkdir(exist_ok=True)
    write_files(folder)


if __name__ == "__main__":
    main()
