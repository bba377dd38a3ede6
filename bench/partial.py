"""Parts matched with whole shapes, and with one another: ``python -m bench.partial [--both]``.

Without ``--data``, parts are cut out of generated people, scaled, and matched with other people;
with it, every shape of the folder that lacks known points is matched with every one that has all.
With ``--cut``, parts are cut out of every shape of the folder, or of generated figures of six
classes, and matched with the one before it in its class. With ``--halves``, the left, right, front,
back, upper and lower half of every shape of the folder are matched with another shape; with
``--views``, what is seen of it from one side.
With ``--both``, both shapes are parts: two generated bodies, each cut on its own, of one person or
of two in turn, which lack opposite sides with ``--opposite``; or every two shapes of the folder
that lack known points. With ``--ends``, too: every shape of the folder, or of generated figures of
six classes, and the one before it in its class, three ends of limbs cut off each.

Printed are the mean geodesic error of the points of the first shape that are matched, over √area of
the second one; of the vertices without a partner, the F1 score on the second shape, and on the
first with ``--both``; the shares of vertices that are said to have a partner, and that do; and the
confidence. ``--fit`` prints the weights of the confidence that fit best.
"""

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from bench.calibration import calibration, print_calibration
from bench.collection import KnownShape, Pair, collection, read_collection, require
from bench.command_line import command_line, parsed, print_json
from bench.cut import CUTS, HALF, VERTICES, cut_out, generated_part
from bench.halves import half_pairs
from bench.logistic import fit_logistic
from bench.map_error import WRONG, map_error
from bench.overlap import generated_overlap, truly_covered, without_ends
from bench.views import view_pairs
from solver.arrays import BoolArray, IntArray
from solver.matching import MatchOptions, match
from synthetic import CLASSES

MEASURES = "score", "margin"
MEASURES_OF_BOTH = ("margin",)

_COUNT = 12
"""Generated parts by default."""


@dataclass(frozen=True)
class Cover:
    """Vertices of one shape that are said to have a partner.

    Parameters
    ----------
    f1
        F1 score of those without one.
    share, true_share
        Of the vertices with a partner, found and true.
    """

    f1: float
    share: float
    true_share: float

    @classmethod
    def of(cls, shape: KnownShape, other: KnownShape, mapped: IntArray) -> "Cover":
        """Compare the numbers of the vertices that a map has with the truth."""
        mesh = shape.shape.mesh
        covered: BoolArray = np.zeros(mesh.n_vertices, dtype=np.bool_)
        covered[mesh.vertices_of(mapped)] = True
        true = truly_covered(shape, other)
        right = int((~covered & ~true).sum())
        f1 = 2.0 * right / max(int((~covered).sum() + (~true).sum()), 1)
        return cls(f1, float(covered.mean()), float(true.mean()))


@dataclass(frozen=True)
class MatchedPart:
    """One match of a part.

    Parameters
    ----------
    name
        Of both shapes.
    error
        Mean error of the part's points.
    part, whole
        What is said to have a partner.
    probability, measures
        The confidence.
    seconds
        Processor time.
    """

    name: str
    error: float
    part: Cover
    whole: Cover
    probability: float
    measures: dict[str, float]
    seconds: float


def pairs(
    folder: Path | None, count: int, first: int, vertices: tuple[int, int] = VERTICES
) -> Iterator[Pair]:
    """Yield parts and wholes."""
    if folder is None:
        for seed in range(first, first + count):
            _, part, whole = generated_part(seed, vertices)
            yield part, whole
        return
    parts, wholes = _read(folder)
    for part in parts:
        for whole in wholes:
            yield part, whole


def cut_pairs(folder: Path | None, first: int) -> Iterator[Pair]:
    """Yield a part of each shape, and the one before it in its class."""
    kinds = [*CUTS, HALF]
    for seed, (one, other) in enumerate(_neighbours(folder), first):
        yield cut_out(one, kinds[seed % len(kinds)], np.random.default_rng(seed)), other


def _neighbours(folder: Path | None) -> list[Pair]:
    """Each shape, and the one before it in its class."""
    classes: dict[str, list[KnownShape]] = {}
    for one in collection(folder, classes=len(CLASSES)):
        classes.setdefault(one.category, []).append(one)
    return [
        (one, shapes[number - 1])
        for shapes in classes.values()
        for number, one in enumerate(shapes)
        if len(shapes) > 1
    ]


def overlapping_pairs(
    folder: Path | None, count: int, first: int, opposite: bool
) -> Iterator[Pair]:
    """Yield pairs of parts."""
    if folder is None:
        for seed in range(first, first + count):
            _, source, target = generated_overlap(seed, opposite)
            yield source, target
        return
    yield from combinations(_read(folder)[0], 2)


def chosen_pairs(arguments: argparse.Namespace) -> Iterator[Pair]:
    """Pairs that the command line asks for."""
    folder, first = arguments.data, arguments.first
    if arguments.ends:
        return ((without_ends(one), without_ends(other)) for one, other in _neighbours(folder))
    if arguments.halves:
        return half_pairs(read_collection(folder))
    if arguments.views:
        return view_pairs(read_collection(folder), first)
    if arguments.cut:
        return cut_pairs(folder, first)
    count = _COUNT if arguments.count is None else arguments.count
    if arguments.both:
        return overlapping_pairs(folder, count, first, arguments.opposite)
    if arguments.vertices is None:
        return pairs(folder, count, first)
    return pairs(folder, count, first, (arguments.vertices, arguments.vertices + 1))


def _read(folder: Path) -> tuple[list[KnownShape], list[KnownShape]]:
    """Shapes that lack known points, and those that have all."""
    parts: list[KnownShape] = []
    wholes: list[KnownShape] = []
    for one in read_collection(folder):
        if one.truth is not None:
            (wholes if (one.truth >= 0).all() else parts).append(one)
    return parts, wholes


def landmarks_of(part: KnownShape, whole: KnownShape, count: int) -> tuple[tuple[int, int], ...]:
    """Known points far apart, the first of them far from the middle, as a person would set them."""
    assert part.truth is not None
    assert whole.truth is not None
    ours, theirs = part.truth, whole.truth
    pairs = np.stack([ours, theirs], axis=1)[(ours >= 0) & (theirs >= 0)]
    places = part.shape.surface.vertices[pairs[:, 0]]
    apart = np.linalg.norm(places - places.mean(axis=0), axis=1)
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(int(apart.argmax()))
        away = np.linalg.norm(places - places[chosen[-1]], axis=1)
        apart = away if len(chosen) == 1 else np.minimum(apart, away)
    ids = (
        part.shape.mesh.vertex_ids[pairs[chosen, 0]],
        whole.shape.mesh.vertex_ids[pairs[chosen, 1]],
    )
    return tuple((int(one), int(other)) for one, other in zip(*ids, strict=True))


def matched(
    part: KnownShape, whole: KnownShape, options: MatchOptions, landmarks: int
) -> MatchedPart:
    """Match a part and compare the answer with the truth."""
    options = replace(options, landmarks=landmarks_of(part, whole, landmarks))
    started = time.process_time()
    found = match(part.shape, whole.shape, options)
    seconds = time.process_time() - started
    assert found.dense is not None
    assert found.dense.inverse is not None
    assert found.confidence is not None
    return MatchedPart(
        f"{part.name} {whole.name}",
        map_error(part, whole, found.dense).direct,
        Cover.of(part, whole, found.dense.source),
        Cover.of(whole, part, found.dense.inverse.source),
        found.confidence.probability,
        dict(found.confidence.measures),
        seconds,
    )


def print_row(one: MatchedPart, both: bool) -> None:
    """Print the figures of a match."""
    sides = (one.part, one.whole) if both else (one.whole,)
    figures = [
        *(side.f1 for side in sides),
        *(figure for side in sides for figure in (side.share, side.true_share)),
        one.probability,
        one.seconds,
    ]
    row = "".join(f"{figure:7.2f}" for figure in figures)
    print(f"{one.name:42}{one.error:8.4f}{row}", flush=True)


def figures_of(answers: Sequence[MatchedPart], both: bool) -> dict[str, float]:
    """Figures of all matches."""
    errors = np.array([one.error for one in answers])
    ours = {"f1_source": float(np.mean([one.part.f1 for one in answers]))} if both else {}
    return {
        "pairs": len(answers),
        "direct": float(errors.mean()),
        "median": float(np.median(errors)),
        "wrong": int((errors > WRONG).sum()),
        "f1": float(np.mean([one.whole.f1 for one in answers])),
        **ours,
        "seconds": float(np.mean([one.seconds for one in answers])),
    }


def main() -> None:
    """Match all parts and print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--count", type=int, help="generated parts")
    parser.add_argument("--first", type=int, default=0, help="seed of the first of them")
    parser.add_argument("--vertices", type=int, help="vertices of the generated bodies")
    parser.add_argument("--cut", action="store_true", help="cut shapes of the folder")
    parser.add_argument("--halves", action="store_true", help="halve shapes of the folder")
    parser.add_argument("--views", action="store_true", help="one-sided views of the folder's")
    parser.add_argument("--landmarks", type=int, default=0, help="known points that are given")
    parser.add_argument("--both", action="store_true", help="match parts with parts")
    parser.add_argument("--opposite", action="store_true", help="cut opposite sides off them")
    parser.add_argument("--ends", action="store_true", help="cut ends off both")
    parser.add_argument("--detected", action="store_true", help="do not say which is the part")
    parser.add_argument("--fit", action="store_true", help="fit the confidence")
    arguments = parsed(parser)
    if arguments.vertices is not None and (arguments.data or arguments.cut or arguments.both):
        parser.error("--vertices is for generated parts of whole bodies: leave out the others")
    if arguments.count is not None and (arguments.data or arguments.cut):
        parser.error("--count is for generated parts: leave out --data and --cut")
    of_folder = arguments.halves, arguments.views
    if any(of_folder) and (all(of_folder) or arguments.cut or arguments.both or not arguments.data):
        parser.error("--halves or --views: give --data, leave out --cut and --both")
    if arguments.ends and (arguments.cut or any(of_folder) or arguments.count is not None):
        parser.error("--ends cuts shapes of its own: leave out other cuts and --count")
    if arguments.opposite and (arguments.data or not arguments.both):
        parser.error("--opposite is for generated bodies: give --both, leave out --data")
    both = arguments.both or arguments.ends
    partial = "detected" if arguments.detected else "both" if both else "source"
    options = MatchOptions(dense=True, partial=partial, proof="candidates")
    f1, shares = f"{'F1':>7}" * (1 + both), f"{'share':>7}{'true':>7}" * (1 + both)
    print(f"{'part and whole':42}{'error':>8}{f1}{shares}{'P':>7}{'s':>7}")
    answers = []
    for part, whole in chosen_pairs(arguments):
        answers.append(matched(part, whole, options, arguments.landmarks))
        print_row(answers[-1], both)
    require(parser, answers)
    found = figures_of(answers, both)
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in found.items()))
    right = np.array([one.error for one in answers]) <= WRONG
    if right.any() and not right.all():
        probabilities = np.array([one.probability for one in answers])
        print_calibration("confidence", calibration(probabilities, right))
        if arguments.fit:
            names = list(MEASURES_OF_BOTH if both else MEASURES)
            measures = np.array([[one.measures[name] for name in names] for one in answers])
            print(fit_logistic(names, measures, right, balanced=True))
    print_json(arguments, found)


if __name__ == "__main__":
    main()
