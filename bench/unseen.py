"""Prototype matched with unseen scans: ``python -m bench.unseen``.

Bodies are scanned under conditions that real scanners and their users make
(:mod:`bench.conditions`): few and many vertices, noise, holes, limbs cut off, hands glued to hips,
other units, bumps. Each scan is matched with a prototype of generated humans or animals, by default
options, and judged on the clean surface: right if no point is farther than 0.5 √area from its place
up to the symmetry of the body, direct if left is left besides; told is the share of scans that the
user is told are unlike the class, and untold that of those which are wrong and not told of.

Generated bodies are of poses and proportions of their own. With ``--data`` there are real ones as
well, and misfits of whole classes, also of those that no prototype here is for.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as Drawing
from scipy.spatial import KDTree

from bench.bodies import Body, generated_animals, generated_humans, real_bodies, unit
from bench.collection import KnownShape, known_of_classes, read_collection
from bench.command_line import command_line, parsed, print_json
from bench.conditions import CONDITIONS, scanned
from bench.drawing import Matched, draw_pair, save
from bench.figure6 import RIGHT, learn
from bench.humans import Family, human_family
from bench.quadrupeds import quadruped_family
from solver.prototype import Prototype, match_prototype
from solver.shape import Shape

PICTURE = Path("bench-output/unseen.png")
CLEAN = "as it is"

_HUMANS, _ANIMALS = ("michael", "gorilla"), ("cat", "dog", "horse")


@dataclass(frozen=True, eq=False)
class Verdict:
    """Result on a scan.

    Attributes
    ----------
    direct, mirrored
        Greatest error of a point, over √area of the clean surface.
    mean
        The mean error, of the better of both.
    misfit
        How much the answer misfits the class.
    seconds
        From the mesh to the answer.
    warnings
        What the user is told.
    """

    direct: float
    mirrored: float
    mean: float
    misfit: float
    seconds: float
    warnings: tuple[str, ...]

    @property
    def right(self) -> bool:
        """True if all points are right, up to symmetry."""
        return min(self.direct, self.mirrored) < RIGHT

    @property
    def told(self) -> bool:
        """True if the match has a misfit warning."""
        return any("unlike" in warning for warning in self.warnings)


def judged(prototype: Prototype, body: Body, condition: str) -> Verdict:
    """Scan a body, match it, compare with the truth."""
    scan = scanned(body.clean.mesh, CONDITIONS[condition])
    started = time.perf_counter()
    answer = match_prototype(prototype, Shape(scan.mesh))
    seconds = time.perf_counter() - started
    tree = KDTree(body.clean.mesh.vertices)
    there = np.asarray(tree.query(scan.places[answer.best.target])[1], dtype=np.int64)
    distances = body.clean.metric("geodesic").distances(there)
    rows, source = np.arange(len(there)), answer.best.source
    direct, mirrored = (distances[rows, one[source]] for one in (body.truth, body.mirrored))
    return Verdict(
        float(direct.max()),
        float(mirrored.max()),
        float(min(direct.mean(), mirrored.mean())),
        float("nan") if answer.misfit is None else answer.misfit,
        seconds,
        answer.warnings,
    )


def table(title: str, rows: Mapping[str, Sequence[Verdict]]) -> dict[str, dict[str, float]]:
    """Print a row for each condition, or body, with the shares that are right."""
    heads = "scans", "direct", "right", "mean", "misfit", "told", "untold", "s"
    print(f"\n{title:28}" + "".join(f"{head:>9}" for head in heads))
    figures = {}
    for name, verdicts in rows.items():
        found = {
            "direct": float(np.mean([one.direct < RIGHT for one in verdicts])),
            "right": float(np.mean([one.right for one in verdicts])),
            "mean": float(np.mean([one.mean for one in verdicts])),
            "misfit": float(np.median([one.misfit for one in verdicts])),
            "told": float(np.mean([one.told for one in verdicts])),
            "wrong_untold": float(np.mean([not (one.right or one.told) for one in verdicts])),
            "seconds": float(np.median([one.seconds for one in verdicts])),
        }
        print(
            f"{name:28}{len(verdicts):9}{found['direct']:9.0%}{found['right']:9.0%}"
            f"{found['mean']:9.3f}{found['misfit']:9.2f}{found['told']:9.0%}"
            f"{found['wrong_untold']:9.0%}{found['seconds']:9.2f}",
            flush=True,
        )
        figures[name] = found
    return figures


def examined(
    title: str, prototype: Prototype, bodies: Sequence[Body], conditions: Sequence[str]
) -> dict[str, dict[str, float]]:
    """Scan all bodies under all conditions, print a table."""
    return table(title, {c: [judged(prototype, body, c) for body in bodies] for c in conditions})


def foreign(prototype: Prototype, shapes: Sequence[KnownShape], own: str) -> dict[str, float]:
    """Print how much whole classes misfit, and of which shapes that is told."""
    print(f"\n{'misfit to the ' + own:28}{'least':>9}{'most':>9}{'told':>9}")
    figures = {}
    ordered = sorted(shapes, key=lambda one: one.category)
    for category, members in groupby(ordered, key=lambda one: one.category):
        answers = [match_prototype(prototype, Shape(unit(one.shape.mesh))) for one in members]
        misfits = [np.nan if one.misfit is None else one.misfit for one in answers]
        told = float(np.mean(np.array(misfits) > prototype.greatest_misfit))
        print(f"{category:28}{min(misfits):9.2f}{max(misfits):9.2f}{told:9.0%}", flush=True)
        figures[category] = told
    return figures


def draw(families: Mapping[str, tuple[Prototype, Family]], bodies: Mapping[str, Body]) -> None:
    """Draw what counts as the truth of real bodies."""
    drawing = Drawing(figsize=(4.2 * len(bodies), 4.6), dpi=70, facecolor="white")
    grid = np.atleast_1d(drawing.subplots(1, len(bodies)))
    for axes, (name, body) in zip(grid, bodies.items(), strict=True):
        prototype, family = families["humans" if name in _HUMANS else "animals"]
        meshes = family.reference.surface, body.clean.surface
        right = np.ones(len(body.truth), dtype=np.bool_)
        draw_pair(axes, Matched(*meshes, prototype.vertices, body.truth, right))
        axes.set_title(body.name, fontsize=10)
    save(drawing, PICTURE)
    print(f"\n{PICTURE}")


def main() -> None:
    """Learn both prototypes, examine them, print tables."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--examples", type=int, default=64)
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument(
        "--condition", action="append", choices=CONDITIONS, help="one of them; may be repeated"
    )
    arguments = parsed(parser)
    shapes = read_collection(arguments.data) if arguments.data else []
    known = known_of_classes(parser, shapes, (*_HUMANS, *_ANIMALS)) if arguments.data else []
    conditions = arguments.condition or list(CONDITIONS)
    learned = {}
    for name, make in (("humans", human_family), ("animals", quadruped_family)):
        family = make(arguments.examples - 1)
        learned[name] = learn(family, arguments.examples, 5, arguments.points), family
    bodies = {
        "humans": generated_humans(*learned["humans"]),
        "animals": generated_animals(*learned["animals"]),
    }
    figures: dict[str, object] = {}
    for name, several in bodies.items():
        prototype = learned[name][0]
        clean = {body.name: [judged(prototype, body, CLEAN)] for body in several}
        figures[f"{name}_clean"] = table(f"generated {name}", clean)
        figures[name] = examined(f"generated {name}", prototype, several, conditions)
    if known:
        drawn = {}
        for category in (*_HUMANS, *_ANIMALS):
            prototype = learned["humans" if category in _HUMANS else "animals"][0]
            poses = [one for one in known if one.category == category]
            if not poses:
                continue
            real = real_bodies(prototype, poses)
            drawn[category] = real[0]
            figures[category] = examined(category, prototype, real, conditions)
        draw(learned, drawn)
        for name, (prototype, _) in learned.items():
            figures[f"foreign_to_{name}"] = foreign(prototype, shapes, name)
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
