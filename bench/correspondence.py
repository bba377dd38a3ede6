"""Error of matched points against the truth: ``python -m bench.correspondence``.

Geodesic error over √area (the Princeton protocol), against the direct truth and against the better
of the direct and the mirrored one, per pair of shapes of a class. An answer is right if no point is
farther than 0.25 from its direct partner. ``--sound`` leaves out points whose known partner lies on
another part of the body (:mod:`bench.sound_truth`).
"""

import argparse
import time
from pathlib import Path

import numpy as np

from bench.collection import KnownShape, Pair, collection, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.sound_truth import with_sound_truth
from bench.surface_error import FARTHEST, truths_of
from solver.arrays import BoolArray, FloatArray
from solver.matching import Match, MatchOptions, match


def point_errors(
    source: KnownShape, target: KnownShape, found: Match
) -> tuple[BoolArray, FloatArray]:
    """Which matched points have a partner on the target, and their geodesic errors.

    The errors are (2, K), direct and under the symmetry, over √area. The second is infinite where
    nobody knows the symmetry.
    """
    kept, truths = truths_of(source, target, found.best.source)
    distances = target.shape.metric("geodesic").distances(found.best.target[kept])
    errors = np.full((2, len(distances)), np.inf)
    for row, truth in zip(errors, truths, strict=False):
        row[:] = distances[np.arange(len(distances)), truth] / target.shape.size
    return kept, errors


def mean_errors(source: KnownShape, target: KnownShape, found: Match) -> tuple[float, float]:
    """Mean geodesic error over √area, direct and under the symmetry."""
    direct, mirrored = point_errors(source, target, found)[1].mean(axis=1)
    return float(direct), float(mirrored)


def named_pairs(path: Path, shapes: list[KnownShape]) -> list[Pair]:
    """Read pairs from a file of two names a line; KeyError if one is not that of a known shape."""
    by_name = {shape.name: shape for shape in shapes if shape.truth is not None}
    names = [line.split() for line in path.read_text().splitlines() if line.strip()]
    return [(by_name[a], by_name[b]) for a, b in names]


def answered(
    source: KnownShape, target: KnownShape, options: MatchOptions, sound: bool
) -> tuple[float, ...]:
    """Direct, better and farthest error over √area of a match, its gap, coarse proof and seconds.

    With `sound`, points of torn truth are not counted.
    """
    started = time.perf_counter()
    found = match(source.shape, target.shape, options)
    seconds = time.perf_counter() - started
    known = with_sound_truth(source, target) if sound else (source, target)
    errors = point_errors(*known, found)[1]
    direct, better = float(errors[0].mean()), float(errors.mean(axis=1).min())
    return direct, better, float(errors[0].max()), found.gap, found.levels[0].certified, seconds


def figures_of(rows: list[tuple[float, ...]]) -> dict[str, float]:
    """Figures of all pairs, from what :func:`answered` returned of each."""
    direct, better, farthest, gap, proven, seconds = np.array(rows, dtype=np.float64).T
    return {
        "pairs": len(rows),
        "direct": float(direct.mean()),
        "best": float(better.mean()),
        "share_over_0_1": float((better > 0.1).mean()),
        "direct_over_0_1": float((direct > 0.1).mean()),
        "share_all_within_0_25": float((farthest <= FARTHEST).mean()),
        "median_gap": float(np.median(gap)),
        "coarse_proven": float(proven.mean()),
        "seconds_per_pair": float(np.median(seconds)),
    }


def main() -> None:
    """Match the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--pairs", type=Path, help="file of two names a line; else all in a class")
    parser.add_argument("--points", type=int, default=32)
    pair_options(parser, classes=1)
    parser.add_argument(
        "--orientation",
        action=argparse.BooleanOptionalAction,
        default=MatchOptions().orientation,
        help="tell left from right",
    )
    parser.add_argument("--third-order", type=float, default=0.0, help="weight of that term")
    parser.add_argument("--sound", action="store_true", help="leave out torn truth")
    arguments = parsed(parser)
    if arguments.pairs:
        try:
            shapes = collection(arguments.data, classes=arguments.classes)
            pairs = named_pairs(arguments.pairs, shapes)
        except KeyError as error:
            parser.error(f"--pairs names {error}, which is no shape with known points")
    else:
        pairs = known_pairs(parser, arguments)
    for pair in pairs:
        for one in pair:
            one.shape.spectrum()
    options = MatchOptions(
        points=arguments.points,
        orientation=arguments.orientation,
        third_order=arguments.third_order,
    )
    rows = []
    heads = "direct", "farthest", "better"
    print(
        f"{'pair':34}{heads[0]:>8}{heads[1]:>10}{heads[2]:>8}{'gap':>9}{'proven':>8}{'seconds':>9}"
    )
    for source, target in pairs:
        rows.append(answered(source, target, options, arguments.sound))
        direct, better, farthest, gap, proven, seconds = rows[-1]
        print(
            f"{source.name + ' ' + target.name:34}{direct:8.3f}{farthest:10.3f}{better:8.3f}"
            f"{gap:9.2%}{'coarse' if proven else '-':>8}{seconds:9.2f}",
            flush=True,
        )
    figures = figures_of(rows)
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in figures.items()))
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
