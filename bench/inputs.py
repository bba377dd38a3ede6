"""Pictures of what comes out of a scanner, matched: ``python -m bench.inputs``.

A person is matched, over HTTP, with another pose of it that was cut at the waist and has debris
around it, with a half of that pose, and with points of it. The pictures, one above the other, are
those that the service draws.
"""

from io import BytesIO
from pathlib import Path

import numpy as np
from isomatch import Client
from PIL import Image

from bench.clouds import sampled
from bench.command_line import command_line
from demo.stack import running_stack
from solver.arrays import FloatArray, IntArray
from solver.mesh import triangle_mesh
from synthetic import articulated, submesh

_WIDTH = 1000
"""Pixels of a picture."""


def inputs(seed: int = 1) -> dict[str, FloatArray | tuple[FloatArray, IntArray]]:
    """Return what is matched: vertices and faces, or points."""
    whole = articulated("human", "walking", 4000, seed)
    vertices, faces = whole.vertices, whole.faces
    height = whole.rest[:, 1]
    waist = np.quantile(height, 0.55)
    upper, lower = np.all(height[faces] > waist, axis=1), np.all(height[faces] <= waist, axis=1)
    mesh = triangle_mesh(vertices, faces)
    half = submesh(mesh, upper)[1]
    points, _ = sampled(mesh, 4000, 0.0)
    return {
        "two pieces and debris": _with_debris(vertices, faces[upper | lower], seed),
        "a half": (half.vertices, half.faces),
        "points": points,
    }


def _with_debris(vertices: FloatArray, faces: IntArray, seed: int) -> tuple[FloatArray, IntArray]:
    rng = np.random.default_rng(seed)
    size = np.ptp(vertices, axis=0)
    corners = vertices.min(axis=0) + size * rng.random((40, 1, 3))
    crumbs = (corners + 0.004 * size.max() * rng.normal(size=(40, 3, 3))).reshape(-1, 3)
    further = np.arange(len(crumbs)).reshape(-1, 3) + len(vertices)
    return np.vstack([vertices, crumbs]), np.vstack([faces, further])


def in_palette(picture: Image.Image) -> Image.Image:
    """Return a picture in 256 colours, with the vivid ones of its points among them."""
    return picture.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=3)


def main() -> None:
    """Match, and write the pictures one above the other."""
    parser = command_line(__doc__)
    parser.add_argument("--output", type=Path, default=Path("bench-output/meshes.png"))
    arguments = parser.parse_args()
    person = articulated("human", "standing", 4000, 0)
    pictures = []
    with running_stack({"ISOMATCH_LOG_LEVEL": "WARNING"}) as stack, Client(stack.url) as client:
        source = client.upload((person.vertices, person.faces), name="a person")
        for name, arrays in inputs().items():
            target = client.upload(arrays, name=name)
            job = client.match(source, target, dense=True)
            found = job.result()
            print(name, found.confidence, found.overlap or "", *found.warnings, sep="\n  ")
            pictures.append(Image.open(BytesIO(job.picture())).convert("RGB"))
    rows = [one.resize((_WIDTH, round(one.height * _WIDTH / one.width))) for one in pictures]
    page = Image.new("RGB", (_WIDTH, sum(one.height for one in rows)), "white")
    top = 0
    for one in rows:
        page.paste(one, (0, top))
        top += one.height
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    in_palette(page).save(arguments.output, optimize=True)


if __name__ == "__main__":
    main()
