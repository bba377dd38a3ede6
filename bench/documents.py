"""Pictures of docs/parts.md and docs/templates.md: ``python -m bench.documents``.

Over HTTP, a body that lacks an arm, a lower leg and half of its back is matched with another pose,
and a template is registered to five bodies. The pictures are those that the service draws.
"""

from io import BytesIO
from pathlib import Path

import numpy as np
from isomatch import Client
from PIL import Image

from bench.command_line import command_line
from bench.humans import random_proportions
from bench.inputs import in_palette
from demo.stack import running_stack
from solver.arrays import FloatArray, IntArray
from solver.mesh import triangle_mesh
from synthetic import ASYMMETRIC_HUMAN, human

_PARTS_WIDTH, _TEMPLATES_WIDTH = 1000, 1120
"""Pixels of the pictures."""

_BODIES = 5
_PROPORTIONS = {
    "head": (0.92, 1.08),
    "arm": (0.9, 1.1),
    "leg": (0.85, 1.15),
    "torso": (0.9, 1.1),
    "shoulders": (0.9, 1.1),
    "girth": (0.8, 1.25),
    "limbs": (0.8, 1.25),
}
"""Ranges of the proportions of the bodies."""


def part(seed: int = 3) -> tuple[FloatArray, IntArray]:
    """Return vertices and faces of a walking body without an arm, a lower leg and half a back."""
    whole = human("walking", ASYMMETRIC_HUMAN, resolution=3000, seed=seed)
    x, y, z = whole.rest.T
    arm = x > 0.32
    leg = (x < 0.0) & (y < -0.55)
    back = (x > 0.0) & (z < -0.02) & (y > 0.05) & (y < 0.45)
    kept = ~(arm | leg | back)
    mesh = triangle_mesh(whole.vertices, whole.faces[kept[whole.faces].all(axis=1)])
    return mesh.vertices, mesh.faces


def draw_part(client: Client) -> bytes:
    """Match the part with the whole."""
    whole = human("reaching", ASYMMETRIC_HUMAN, resolution=2200, seed=8)
    source = client.upload(part(), name="part.off")
    target = client.upload((whole.vertices, whole.faces), name="whole.off")
    job = client.match(source, target, dense=True, partial="source")
    found = job.result()
    print(found.confidence, found.overlap, *found.warnings, sep="\n")
    return job.picture(view="back")


def draw_template(client: Client) -> bytes:
    """Register a template to bodies of different proportions."""
    rng = np.random.default_rng(5)
    bodies = [
        human("standing", random_proportions(_PROPORTIONS, rng), resolution=2000 + 100 * k, seed=k)
        for k in range(_BODIES)
    ]
    template = human("standing", resolution=2000, seed=_BODIES)
    shape = client.upload((template.vertices, template.faces), name="generated bodies")
    specimens = [
        client.upload((body.vertices, body.faces), name=f"specimen{k}.ply")
        for k, body in enumerate(bodies, start=1)
    ]
    job = client.register(shape, specimens, scale=True)
    print(job.result())
    return job.picture()


def save(picture: bytes, path: Path, width: int) -> None:
    """Write a picture of a width, in pixels."""
    image = Image.open(BytesIO(picture)).convert("RGB")
    image = image.resize((width, round(image.height * width / image.width)))
    in_palette(image).save(path, optimize=True)


def main() -> None:
    """Write the pictures into a folder."""
    parser = command_line(__doc__)
    parser.add_argument("--output", type=Path, default=Path("bench-output"))
    output = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    with running_stack({"ISOMATCH_LOG_LEVEL": "WARNING"}) as stack, Client(stack.url) as client:
        save(draw_part(client), output / "parts.png", _PARTS_WIDTH)
        save(draw_template(client), output / "templates.png", _TEMPLATES_WIDTH)


if __name__ == "__main__":
    main()
