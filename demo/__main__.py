"""Start the stack, match two generated figures, and show the answer."""

import argparse
import signal
import sys
import time
from pathlib import Path
from types import FrameType

from isomatch import Client, IsomatchError, Match
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from demo.figures import Figures, generate, write_off
from demo.stack import StackError, running_stack
from solver.arrays import FloatArray

POINTS = 32
VERTICES = 4000

NEXT = """What next:
  make serve                                    a service that stays, seen at http://127.0.0.1:8000
  .venv/bin/isomatch match YOURS.off OTHER.obj  your own meshes, against that service
  client/README.md                              the same from Python"""


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m demo", description=__doc__)
    parser.add_argument(
        "--output", type=Path, default=Path("demo-output"), help="folder for what is made"
    )
    parser.add_argument("--vertices", type=int, default=VERTICES, help="size of the first figure")
    return parser.parse_args()


def main() -> int:
    """Run the demo and return its exit code."""
    options = arguments()
    # A terminated demo stops its service as an interrupted one does.
    signal.signal(signal.SIGTERM, _interrupt)
    console = Console(highlight=False, soft_wrap=True)
    try:
        demonstrate(console, options.output, options.vertices)
    except (StackError, IsomatchError, OSError) as error:
        console.print(f"The demo failed: {error}", markup=False)
        return 1
    except KeyboardInterrupt:
        console.print("Interrupted; everything is stopped.")
        return 130
    return 0


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def demonstrate(console: Console, output: Path, vertices: int) -> None:
    """Do everything once, writing files into the folder `output`."""
    start = time.monotonic()
    output.mkdir(parents=True, exist_ok=True)
    console.print("Generating a figure in two poses, triangulated apart ...")
    figures = generate(vertices)
    files = (output / "standing.off", output / "walking.off")
    for path, shape in zip(files, (figures.source, figures.target), strict=True):
        write_off(path, shape)
        console.print(f"  {path}: {len(shape.vertices)} vertices, {len(shape.faces)} triangles")

    console.print("Starting the service; the first time, its numerics are compiled: minutes ...")
    with running_stack() as stack:
        console.print(f"  it listens on {stack.url}")
        console.print("Uploading and matching ...")
        with Client(stack.url) as client:
            source, target = (client.upload(path) for path in files)
            job = client.match(source, target, points=POINTS)
            match = job.result(progress=True)
            match.save(output / "match.json")
            job.save_picture(output / "match.png")
        show(console, match, figures)
        console.print("Stopping the service ...")
    console.print(
        f"Done in {time.monotonic() - start:.0f} s. {output / 'match.png'} shows both figures, "
        f"corresponding points in the same colour; {output / 'match.json'} has everything.\n"
    )
    console.print(NEXT)


def show(console: Console, match: Match, figures: Figures) -> None:
    """Print the correspondences, what is proven of them, and how far they are from the truth."""
    direct, mirrored = figures.errors(match.pairs)
    flipped = float(mirrored.mean()) < float(direct.mean())
    errors = mirrored if flipped else direct
    console.print(correspondence_table(match, errors))
    distortion = match.distortion
    first_order = "none" if distortion.first_order is None else f"{distortion.first_order:.4g}"
    coarse = match.levels[0]
    proof = "best of its candidates" if coarse.certified else f"gap {coarse.gap:.2%}"
    if match.confidence is not None:
        console.print(f"answer        {match.confidence}")
    console.print(
        f"distortion    second order {distortion.second_order:.4g}, first order {first_order}, "
        f"largest {distortion.linf:.4g}\n"
        f"energy        {match.energy:.6g}\n"
        f"lower bound   {match.lower_bound:.6g}: gap {match.gap:.2%}, "
        f"{'certified among its candidates' if match.certified else 'not certified'}\n"
        f"coarse level  {coarse.points} points, {proof}\n"
        f"alternatives  {len(match.alternatives)} more\n"
        f"time          {match.timings['total']:.1f} s in the worker\n"
        f"mean error    {errors.mean():.4f}, where the square root of the area is 1, from the "
        f"{'mirror image of the ' if flipped else ''}truth"
    )


def correspondence_table(match: Match, errors: FloatArray) -> Table:
    """Return the pairs with their costs and their distances from the truth."""
    names = ("source", "target", "cost", "error")
    table = Table(*(Column(name, justify="right") for name in names), box=SIMPLE_HEAD)
    for (source, target), cost, error in zip(match.pairs, match.costs, errors, strict=True):
        table.add_row(str(source), str(target), f"{cost:.4g}", f"{error:.4f}")
    return table


if __name__ == "__main__":
    sys.exit(main())
