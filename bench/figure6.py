"""Figure 6, prototype of humans and figures outside the class: ``python -m bench.figure6``.

A prototype is learned from humans with varied heads, arms and legs, in random poses. Figures
outside of this family, each triangulated on its own, are matched with one human of standard
proportions (deterministic) and with the prototype (probabilistic), by the same structures and as
many points.
Both are judged by where the points are in truth, up to the left-right symmetry of the whole body: a
figure is right if no point is farther from its place than 0.5 √area, which is nearer than from the
end of a limb to that of another, or to the head. By a stricter measure, it is exact if every point
was put nearer to its own place than to that of any other point; and direct if it is right with left
being left. ``--orientation`` has the prototype tell left from right by its surfaces.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import permutations
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as Drawing

from bench.collection import KnownShape, known_of_classes, read_collection
from bench.command_line import command_line, parsed, print_json
from bench.drawing import Matched, draw_pair, save
from bench.humans import Family, Unfamiliar, human_family, unfamiliar_figures
from bench.surface_error import FARTHEST
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.matching import MAX_COARSE_POINTS, Match, MatchOptions, match
from solver.prototype import (
    Prototype,
    PrototypeOptions,
    connected_examples,
    learn_prototype,
    match_prototype,
)
from solver.shape import Shape

PICTURE = Path("bench-output/figure6.png")
REAL_PICTURE = Path("bench-output/figure6-real.png")
RIGHT = 0.5
CHOOSING, HELD_OUT = 2, 1002
"""Seeds of the figures that settings were chosen by, and of those that are reported."""

_EXAMPLES = 8, 16, 32, 64, 128
_COMPONENTS = 1, 2, 3, 5, 8
_DRAWN = 4
_BODIES = "michael", "gorilla", "david", "victoria"


@dataclass(frozen=True, eq=False)
class Answer:
    """A match of a figure, judged.

    Attributes
    ----------
    here, there
        (N,) vertices of the reference and of the figure.
    errors
        (N,) geodesic distances from the true places, over √area.
    exact
        (N,) bool, whether no other point's place is nearer than its own.
    direct
        Whether all points are right, and left is left.
    certified
        Whether the optimum is proven.
    seconds
        Of the match, once the structures are known.
    """

    here: IntArray
    there: IntArray
    errors: FloatArray
    exact: BoolArray
    direct: bool
    certified: bool
    seconds: float


def learn(family: Family, examples: int, components: int, points: int) -> Prototype:
    """Learn a prototype from the standard human and the first examples."""
    options = PrototypeOptions(points=points, components=components)
    shapes = [family.reference, *family.examples[: examples - 1]]
    return learn_prototype(connected_examples(shapes, options).examples, options)


def judged(
    solve: Callable[[], Match], here: IntArray | None, family: Family, figure: Unfamiliar
) -> Answer:
    """Match once to warm up and once against the clock, and compare with the truth."""
    solve()
    started = time.perf_counter()
    answer = solve()
    seconds = time.perf_counter() - started
    source = answer.best.source if here is None else here[answer.best.source]
    there = answer.best.target
    found = figure.shape.metric("geodesic").distances(there)
    judgements = []
    for places in (figure.truth[source], figure.truth[family.mirrored[source]]):
        between = found[:, places]
        errors = np.diagonal(between)
        judgements.append((errors, errors <= between.min(axis=1)))
    errors, exact = max(judgements, key=lambda one: -one[0].max())
    direct = bool(judgements[0][0].max() < RIGHT)
    return Answer(source, there, errors, exact, direct, answer.certified, seconds)


def usual_options(points: int) -> MatchOptions:
    """Options of a match of two shapes by the prototype's structures."""
    coarse = min(points, MAX_COARSE_POINTS)
    return MatchOptions(
        points=points, coarse_points=coarse, metric=("geodesic",), orientation=False
    )


def deterministic(family: Family, figures: list[Unfamiliar], options: MatchOptions) -> list[Answer]:
    """Match every figure with the standard human."""
    return [
        judged(partial(match, family.reference, figure.shape, options), None, family, figure)
        for figure in figures
    ]


def probabilistic(
    prototype: Prototype,
    family: Family,
    figures: list[Unfamiliar],
    points: int,
    orientation: bool = False,
) -> list[Answer]:
    """Match every figure with the prototype."""
    options = MatchOptions(points=points, orientation=orientation)
    return [
        judged(
            partial(match_prototype, prototype, figure.shape, options),
            prototype.vertices,
            family,
            figure,
        )
        for figure in figures
    ]


def right_share(answers: list[Answer]) -> float:
    """Share of the figures all of whose points are right."""
    return float(np.mean([answer.errors.max() < RIGHT for answer in answers]))


def direct_share(answers: list[Answer]) -> float:
    """Share of the figures that are right, left being left."""
    return float(np.mean([answer.direct for answer in answers]))


def exact_share(answers: list[Answer]) -> float:
    """Share of the figures whose points are all nearest to their own places."""
    return float(np.mean([answer.exact.all() for answer in answers]))


def row_of(answers: list[Answer]) -> str:
    """Show what is known of some answers as a row of the table."""
    errors = np.concatenate([answer.errors for answer in answers])
    return (
        f"{right_share(answers):9.1%}{exact_share(answers):9.1%}{direct_share(answers):9.1%}"
        f"{np.mean(errors < RIGHT):9.1%}{np.mean(errors < FARTHEST):9.1%}"
        f"{errors.mean():9.3f}{np.mean([a.certified for a in answers]):9.0%}"
        f"{np.median([a.seconds for a in answers]) * 1e3:9.1f}"
    )


def shares_of(columns: dict[str, list[Answer]]) -> dict[str, float]:
    """Shares of the figures that are right, direct, exact and proven, by column of the table."""
    shares = {}
    for name, answers in columns.items():
        key = name.replace(" ", "_")
        shares[f"{key}_right"] = right_share(answers)
        shares[f"{key}_direct"] = direct_share(answers)
        shares[f"{key}_exact"] = exact_share(answers)
        shares[f"{key}_certified"] = float(np.mean([one.certified for one in answers]))
    return shares


def sensitivity(
    family: Family, figures: list[Unfamiliar], arguments: argparse.Namespace
) -> dict[str, dict[str, float]]:
    """Share of right figures by number of examples, and by number of components."""

    def share(examples: int, components: int) -> float:
        prototype = learn(family, examples, components, arguments.points)
        return right_share(probabilistic(prototype, family, figures, arguments.points))

    found = {
        "examples": {str(m): share(m, arguments.components) for m in _EXAMPLES},
        "components": {str(k): share(arguments.examples, k) for k in _COMPONENTS},
    }
    for name, shares in found.items():
        print(f"\n{name:12}" + "".join(f"{count:>9}" for count in shares))
        print(f"{'right':12}" + "".join(f"{value:9.1%}" for value in shares.values()))
    return found


def agreement(
    shapes: list[KnownShape], solve: Callable[[Shape], IntArray]
) -> dict[str, tuple[int, float]]:
    """Compare points found independently on two poses of one body.

    Parameters
    ----------
    shapes
        Real shapes with ground truth within their class.
    solve
        (N,) vertices of a shape, of each of the prototype's points.

    Returns
    -------
    For each class, its number of ordered pairs and the share of them where all points agree.
    """
    found = {known.name: solve(known.shape) for known in shapes}
    right: dict[str, list[bool]] = {}
    for a, b in permutations(shapes, 2):
        if a.category != b.category or a.truth is None or b.truth is None:
            continue
        near = a.shape.metric("geodesic").distances(found[a.name])[:, a.truth].argmin(axis=1)
        there = b.shape.metric("geodesic").distances(found[b.name])
        rows = np.arange(len(near))
        truths = [b.truth, *([b.symmetric_truth] if b.symmetric_truth is not None else [])]
        errors = min(float(there[rows, truth[near]].max()) for truth in truths)
        right.setdefault(a.category, []).append(errors < RIGHT)
    return {category: (len(one), float(np.mean(one))) for category, one in right.items()}


def real_bodies(prototype: Prototype, family: Family, shapes: list[KnownShape]) -> dict[str, float]:
    """Match real bodies with the prototype, draw them, and tell how well poses of one agree."""
    points = prototype.points

    def by_prototype(shape: Shape) -> IntArray:
        return match_prototype(prototype, shape, MatchOptions(points=points)).best.target

    def by_human(shape: Shape) -> IntArray:
        return match(family.reference, shape, usual_options(points)).best.target

    ours, theirs = agreement(shapes, by_prototype), agreement(shapes, by_human)
    print(f"\n{'two poses agree':18}{'pairs':>9}{'one human':>12}{'prototype':>12}")
    for category, (pairs, share) in ours.items():
        print(f"{category:18}{pairs:9}{theirs[category][1]:12.1%}{share:12.1%}")
    figure = Drawing(figsize=(4.2 * len(shapes), 4.6), dpi=70, facecolor="white")
    for axes, known in zip(figure.subplots(1, len(shapes)), shapes, strict=True):
        there = by_prototype(known.shape)
        meshes = family.reference.surface, known.shape.surface
        right = np.ones(len(there), dtype=np.bool_)
        draw_pair(axes, Matched(*meshes, prototype.vertices, there, right))
        axes.set_title(known.name, fontsize=10)
    save(figure, REAL_PICTURE)
    print(f"\n{REAL_PICTURE}")
    return {category: share for category, (_, share) in ours.items()}


def draw(
    family: Family, figures: list[Unfamiliar], columns: dict[str, list[Answer]], path: Path
) -> None:
    """Draw the first figures with both answers, wrong points in red."""
    drawing = Drawing(figsize=(5.0 * len(columns), 4.2 * _DRAWN), dpi=70, facecolor="white")
    grid = drawing.subplots(_DRAWN, len(columns), squeeze=False)
    for row in range(min(_DRAWN, len(figures))):
        for axes, (title, answers) in zip(grid[row], columns.items(), strict=True):
            answer = answers[row]
            meshes = family.reference.surface, figures[row].shape.surface
            right = answer.errors < RIGHT
            draw_pair(axes, Matched(*meshes, answer.here, answer.there, right))
            axes.set_title(f"{title}: {right.sum()} of {len(right)} right", fontsize=11)
    save(drawing, path)
    print(f"\n{path}")


def main() -> None:
    """Match all figures both ways, print a table, draw the figure."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--examples", type=int, default=64)
    parser.add_argument("--components", type=int, default=5)
    parser.add_argument("--figures", type=int, default=50)
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument(
        "--choosing", action="store_true", help="the figures settings are chosen by"
    )
    parser.add_argument("--orientation", action="store_true", help="tell left from right")
    parser.add_argument("--sensitivity", action="store_true", help="to examples and components")
    arguments = parsed(parser)
    shapes = read_collection(arguments.data) if arguments.data else []
    bodies = known_of_classes(parser, shapes, _BODIES) if arguments.data else []
    most = max(arguments.examples, *(_EXAMPLES if arguments.sensitivity else (1,)))
    family = human_family(most - 1)
    figures = unfamiliar_figures(
        family, arguments.figures, CHOOSING if arguments.choosing else HELD_OUT
    )
    started = time.perf_counter()
    prototype = learn(family, arguments.examples, arguments.components, arguments.points)
    learning = time.perf_counter() - started
    print(f"{arguments.examples} examples, learned in {learning:.1f} s; {len(figures)} figures")
    columns = {
        "by default": deterministic(family, figures, MatchOptions(points=arguments.points)),
        "deterministic": deterministic(family, figures, usual_options(arguments.points)),
        "probabilistic": probabilistic(
            prototype, family, figures, arguments.points, arguments.orientation
        ),
    }
    heads = "right", "exact", "direct", "points", "< 0.25", "mean", "proven", "ms"
    print(f"{'':14}" + "".join(f"{head:>9}" for head in heads))
    for name, answers in columns.items():
        print(f"{name:14}{row_of(answers)}")
    drawn = {name: columns[name] for name in ("deterministic", "probabilistic")}
    draw(family, figures, drawn, PICTURE)
    figures_out: dict[str, object] = {
        "figures": len(figures),
        "examples": arguments.examples,
        "components": arguments.components,
        "points": arguments.points,
        "learning_seconds": learning,
        **shares_of(columns),
    }
    if arguments.sensitivity:
        figures_out["sensitivity"] = sensitivity(family, figures, arguments)
    if bodies:
        figures_out["agreement"] = real_bodies(prototype, family, bodies)
    print_json(arguments, figures_out)


if __name__ == "__main__":
    main()
