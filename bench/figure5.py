"""Figure 5, textured shapes: ``python -m bench.figure5``.

Generated figures in clothes, as scans see them (:mod:`bench.scanned`): glued to themselves or not,
with holes, noise, triangulations of their own, coarse where they are flat. Seven points of each
pair, one glued and one not, are matched by commute-time distances and mean RGB values with equal
weights, as in section 6.3, and once more with SI-HKS in place of the colours, which cannot tell
left from right. A match is right where it is on the true part of the shape.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bench.command_line import command_line, parsed, print_json
from bench.drawing import Matched, draw_pair, save
from bench.scanned import (
    HARD,
    OTHER,
    SAME,
    Light,
    ScannedShape,
    lit,
    point_errors,
    scanned_pairs,
    scanned_shapes,
)
from bench.surface_error import FARTHEST
from solver.arrays import FloatArray, IntArray
from solver.matching import MatchOptions, match
from solver.shape.choices import DescriptorChoice, Photometric, ScaleInvariantHeatKernelSignature

PICTURE = Path("bench-output/figure5.png")
POINTS = 7

TEXTURE = "RGB within 0.1"
GEOMETRY = "SI-HKS"
METHODS: dict[str, tuple[DescriptorChoice, Light]] = {
    f"{TEXTURE}, same light": (Photometric(radius=0.1), SAME),
    TEXTURE: (Photometric(radius=0.1), OTHER),
    f"{TEXTURE}, strong light": (Photometric(radius=0.1), HARD),
    "RGB within 0.03": (Photometric(radius=0.03), OTHER),
    GEOMETRY: (ScaleInvariantHeatKernelSignature(), OTHER),
}
"""Descriptors by what the table calls them, and the light that scans are seen in."""


@dataclass(frozen=True, eq=False)
class Answer:
    """Result on a pair.

    Attributes
    ----------
    source, target
        The scans.
    here, there
        (POINTS,) matched vertices.
    errors, mirrored
        (POINTS,) over √area, against the truth and against its mirror image.
    """

    source: ScannedShape
    target: ScannedShape
    here: IntArray
    there: IntArray
    errors: FloatArray
    mirrored: FloatArray

    @property
    def better(self) -> FloatArray:
        """Errors against the truth or its mirror image, whichever is nearer on average."""
        return min(self.errors, self.mirrored, key=lambda one: float(one.mean()))


def answered(source: ScannedShape, target: ScannedShape, descriptor: DescriptorChoice) -> Answer:
    """Match a pair as section 6.3 does: only the descriptor can tell left from right."""
    options = MatchOptions(
        points=POINTS,
        metric=("commute_time",),
        descriptor=(descriptor,),
        beta=1.0,
        first_order_weight=1.0,
        orientation=False,
    )
    found = match(source.shape, target.shape, options).best
    here = source.shape.mesh.vertices_of(found.source)
    there = target.shape.mesh.vertices_of(found.target)
    return Answer(source, target, here, there, *point_errors(source, target, here, there))


def shares(answers: list[Answer]) -> dict[str, float]:
    """Shares of the table, and the mean error."""
    errors = np.array([one.errors for one in answers])
    better = np.array([one.better for one in answers])
    unmirrored = [one.errors.mean() < one.mirrored.mean() for one in answers]
    return {
        "unmirrored": float(np.mean(unmirrored)),
        "points_right": float((errors < FARTHEST).mean()),
        "pairs_right": float((errors < FARTHEST).all(axis=1).mean()),
        "points_right_up_to_symmetry": float((better < FARTHEST).mean()),
        "pairs_right_up_to_symmetry": float((better < FARTHEST).all(axis=1).mean()),
        "mean_error": float(errors.mean()),
    }


def draw(rows: dict[str, tuple[Answer, Answer]], path: Path) -> None:
    """Draw pairs in their colours, matched without them on the left and with them on the right."""
    figure = Figure(figsize=(10.0, 3.6 * len(rows)), dpi=72, facecolor="white")
    grid = figure.subplots(len(rows), 2, squeeze=False)
    for row, (title, answers) in zip(grid, rows.items(), strict=True):
        names = "geometry alone", "with texture"
        for axes, name, answer in zip(row, names, answers, strict=True):
            right = answer.errors < FARTHEST
            meshes = answer.source.shape.surface, answer.target.shape.surface
            draw_pair(axes, Matched(*meshes, answer.here, answer.there, right), colored=True)
            axes.set_title(
                f"{title}: {name}\n{int(right.sum())} of {POINTS} right, "
                f"mean error {answer.errors.mean():.2f}",
                fontsize=10,
            )
    save(figure, path)


def drawn_rows(answers: dict[str, list[Answer]]) -> dict[str, tuple[Answer, Answer]]:
    """A human and another figure that geometry gets most wrong, and the worst case with texture."""
    both = list(zip(answers[GEOMETRY], answers[TEXTURE], strict=True))
    gained = sorted(both, key=lambda one: one[1].errors.mean() - one[0].errors.mean())
    people = [one for one in gained if one[0].source.category == "human"]
    others = [one for one in gained if one[0].source.category != "human"]
    rows = {one[0].source.category: one for one in (people[0], *others[:1])}
    return rows | {"the worst with texture": max(both, key=lambda one: one[1].errors.mean())}


def main() -> None:
    """Match all pairs by every method, print a table, draw some of them."""
    parser = command_line(__doc__)
    parser.add_argument("--resolution", type=int, default=3000, help="vertices of the figures")
    parser.add_argument("--classes", type=int, default=6, help="of figures, the human first")
    arguments = parsed(parser)
    pairs = scanned_pairs(list(scanned_shapes(arguments.resolution, arguments.classes)))
    columns = ("not mirrored", "points", "all points", "points, sym.", "all, sym.", "error")
    print(f"{len(pairs)} pairs, {POINTS} points, share that is right\n")
    print(f"{'':26}" + "".join(f"{column:>14}" for column in columns))
    answers: dict[str, list[Answer]] = {}
    figures: dict[str, dict[str, float]] = {}
    for name, (descriptor, light) in METHODS.items():
        scans = {id(scan): lit(scan, light) for pair in pairs for scan in pair}
        answers[name] = [answered(scans[id(a)], scans[id(b)], descriptor) for a, b in pairs]
        figures[name] = shares(answers[name])
        *parts, error = figures[name].values()
        print(f"{name:26}" + "".join(f"{part:14.1%}" for part in parts) + f"{error:14.3f}")
    draw(drawn_rows(answers), PICTURE)
    print(f"\n{PICTURE}")
    print_json(arguments, {"pairs": len(pairs), "points": POINTS, "methods": figures})


if __name__ == "__main__":
    main()
