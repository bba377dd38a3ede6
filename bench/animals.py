"""Prototype of four-legged animals: ``python -m bench.animals``.

It is learned from mixtures of cat, dog and horse in several poses, and matched with individuals of
each kind, some of them outside of what the examples show, each triangulated on its own. An animal
is right if no point is farther than half √area from its place: directly, left being left, or up to
the symmetry of the body. With ``--data``, prototypes are learned from all but one pose of each real
class, put into correspondence by our own matches, and matched with the pose that was left out.
``--sensitivity`` is to the number of examples, generated and, with ``--data``, real ones, the man's
too.
"""

import argparse
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from bench.collection import KnownShape, read_collection
from bench.command_line import command_line, parsed, print_json
from bench.figure6 import CHOOSING, HELD_OUT, RIGHT, learn, usual_options
from bench.humans import Family, Unfamiliar
from bench.quadrupeds import individuals, quadruped_family
from solver.arrays import FloatArray, IntArray
from solver.matching import Match, MatchOptions, match
from solver.prototype import (
    Prototype,
    PrototypeOptions,
    learn_prototype,
    match_prototype,
    matched_examples,
)

_CLASSES = "cat", "dog", "horse"
_POSES = 3
"""Examples of a real class."""
_EXAMPLES = 4, 8, 24, 64


def errors(
    answer: Match, places: IntArray, animal: Unfamiliar, mirrored: IntArray
) -> tuple[float, float]:
    """Greatest distance of a point from its place, and from its mirror image's, over √area."""
    distances = animal.shape.metric("geodesic").distances(answer.best.target)
    rows = np.arange(len(places))
    direct, reflected = (
        float(distances[rows, animal.truth[one]].max()) for one in (places, mirrored[places])
    )
    return direct, reflected


def measured(
    solve: Callable[[Unfamiliar], Match],
    named: IntArray | None,
    family: Family,
    animals: list[tuple[str, Unfamiliar]],
) -> FloatArray:
    """(A, 3) greatest errors, direct and mirrored, and seconds, of every animal.

    Parameters
    ----------
    solve
        Matches an animal.
    named
        Vertices of the reference that sources of matches name, if these are not vertices.
    family
        Of the reference.
    animals
        With their kinds.
    """
    solve(animals[0][1])  # compiles
    rows = []
    for _, animal in animals:
        started = time.perf_counter()
        answer = solve(animal)
        seconds = time.perf_counter() - started
        source = answer.best.source if named is None else named[answer.best.source]
        rows.append((*errors(answer, source, animal, family.mirrored), seconds))
    return np.array(rows)


def shares(rows: FloatArray) -> tuple[float, float]:
    """Shares of the animals that are right directly, and up to symmetry."""
    direct = float((rows[:, 0] < RIGHT).mean())
    return direct, float((rows[:, :2].min(axis=1) < RIGHT).mean())


def generated(arguments: argparse.Namespace) -> dict[str, float]:
    """Learn a prototype of generated animals, match others, print a table."""
    family, points = quadruped_family(arguments.examples - 1), arguments.points
    seed = CHOOSING if arguments.choosing else HELD_OUT
    animals = individuals(family, arguments.animals, seed)
    for _, animal in animals:
        animal.shape.spectrum()
    started = time.perf_counter()
    prototype = learn(family, arguments.examples, 5, points)
    print(f"{arguments.examples} examples, learned in {time.perf_counter() - started:.1f} s")

    def by_one(animal: Unfamiliar, options: MatchOptions) -> Match:
        return match(family.reference, animal.shape, options)

    def by_class(animal: Unfamiliar, orientation: bool) -> Match:
        options = MatchOptions(points=points, orientation=orientation)
        return match_prototype(prototype, animal.shape, options)

    oriented = MatchOptions(points=points, orientation=True)
    columns = {
        "one animal": measured(
            partial(by_one, options=usual_options(points)), None, family, animals
        ),
        "one animal, oriented": measured(partial(by_one, options=oriented), None, family, animals),
        "prototype": measured(
            partial(by_class, orientation=False), prototype.vertices, family, animals
        ),
        "prototype, oriented": measured(
            partial(by_class, orientation=True), prototype.vertices, family, animals
        ),
    }
    print(f"{len(animals)} animals{'':12}{'direct':>9}{'right':>9}{'s':>9}")
    figures: dict[str, float] = {"animals": len(animals)}
    for name, rows in columns.items():
        direct, right = shares(rows)
        print(f"{name:22}{direct:9.1%}{right:9.1%}{np.median(rows[:, 2]):9.2f}")
        key = name.replace(", ", "_").replace(" ", "_")
        figures |= {f"{key}_direct": direct, f"{key}_right": right}
    for kind in dict.fromkeys(kind for kind, _ in animals):
        own = columns["prototype, oriented"][[kind == other for other, _ in animals]]
        print(f"  {kind:20}{shares(own)[0]:9.1%}{shares(own)[1]:9.1%}")
    return figures


def real(folder: Path, points: int) -> dict[str, float]:
    """Learn prototypes of real animals from all poses but one, and match that one."""
    shapes = [one for one in read_collection(folder) if one.truth is not None]
    figures: dict[str, float] = {}
    print(f"\n{'real, left out':22}{'direct':>9}{'right':>9}{'mean':>9}{'used':>9}")
    for category in _CLASSES:
        own = [one for one in shapes if one.category == category]
        if len(own) <= _POSES:
            continue
        rows = np.array(
            [left_out(one, [other for other in own if other is not one], points) for one in own]
        )
        direct, right = shares(rows)
        print(
            f"{category:22}{direct:9.1%}{right:9.1%}{rows[:, 2].mean():9.3f}{rows[:, 3].mean():9}"
        )
        figures |= {f"{category}_direct": direct, f"{category}_right": right}
    return figures


def sensitivity(arguments: argparse.Namespace) -> dict[str, dict[str, tuple[float, float]]]:
    """Shares that are right, direct and up to symmetry, by the number of examples."""
    family = quadruped_family(max(_EXAMPLES) - 1)
    animals = individuals(family, arguments.animals, HELD_OUT)
    found: dict[str, dict[str, tuple[float, float]]] = {"generated": {}}
    for examples in _EXAMPLES:
        prototype = learn(family, examples, 5, arguments.points)

        def by_class(animal: Unfamiliar, prototype: Prototype = prototype) -> Match:
            return match_prototype(prototype, animal.shape)

        rows = measured(by_class, prototype.vertices, family, animals)
        found["generated"][str(examples)] = shares(rows)
    shapes = read_collection(arguments.data) if arguments.data else []
    for category in (*_CLASSES, "michael"):
        own = [one for one in shapes if one.category == category and one.truth is not None]
        for examples in range(1, _POSES + 1) if len(own) > _POSES else ():
            errors = [
                left_out(own[n], (own[n + 1 :] + own[:n])[:examples], arguments.points)
                for n in range(len(own))
            ]
            found.setdefault(category, {})[str(examples)] = shares(np.array(errors))
    print(f"\n{'right, by examples':22}{'examples':>9}{'direct':>9}{'right':>9}")
    for name, several in found.items():
        for count, (direct, right) in several.items():
            print(f"{name:22}{count:>9}{direct:9.1%}{right:9.1%}")
    return found


def left_out(
    target: KnownShape, others: list[KnownShape], points: int
) -> tuple[float, float, float, int]:
    """Learn from other poses, the first of which is the reference, and match the one left out.

    Returns
    -------
    Greatest errors, direct and mirrored, the mean direct one, and examples used.
    """
    options = PrototypeOptions(points=points)
    found = matched_examples([one.shape for one in others], options)
    prototype = learn_prototype(found.examples, options)
    answer = match_prototype(prototype, target.shape)
    first, points_there = others[0], found.examples[0].vertices[answer.best.source]
    assert first.truth is not None
    known = first.shape.metric("geodesic").distances(points_there)[:, first.truth].argmin(axis=1)
    distances = target.shape.metric("geodesic").distances(answer.best.target)
    rows = np.arange(len(known))
    direct, reflected = (
        distances[rows, truth[known]]
        for truth in (target.truth, target.symmetric_truth)
        if truth is not None
    )
    return float(direct.max()), float(reflected.max()), float(direct.mean()), len(found.kept)


def main() -> None:
    """Match the animals, print tables."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--examples", type=int, default=64)
    parser.add_argument("--animals", type=int, default=48)
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument(
        "--choosing", action="store_true", help="the animals settings are chosen by"
    )
    parser.add_argument("--sensitivity", action="store_true", help="to the number of examples")
    arguments = parsed(parser)
    figures: dict[str, object] = {**generated(arguments)}
    if arguments.data:
        figures |= real(arguments.data, arguments.points)
    if arguments.sensitivity:
        figures["sensitivity"] = sensitivity(arguments)
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
