"""Share of right answers by the number of points: ``python -m bench.points``.

A match is right if all its points are within 0.25 √area of the truth, or all of its mirror image;
it is direct if they are of the truth.
Without ``--data`` the shapes are generated, of all classes.
"""

import argparse
import time

import numpy as np

from bench.collection import Pair, known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.correspondence import point_errors
from bench.surface_error import FARTHEST
from solver.arrays import FloatArray
from solver.matching import MatchOptions, match
from synthetic import CLASSES

_POINTS = 6, 8, 10, 12, 14, 16, 20, 24, 32


def measured(pairs: list[Pair], options: MatchOptions) -> FloatArray:
    """(P, 6) greatest and mean error, certified, rank, seconds and greatest direct error by pair.

    Of the better truth, but for the last. The rank is the coarsest level's, and spectra are known.
    """
    rows = []
    for source, target in pairs:
        started = time.perf_counter()
        found = match(source.shape, target.shape, options)
        seconds = time.perf_counter() - started
        errors = point_errors(source, target, found)[1]
        greatest, mean = errors.max(axis=1).min(), errors.mean(axis=1).min()
        direct = errors[0].max()
        rows.append((greatest, mean, found.certified, found.levels[0].rank, seconds, direct))
    return np.array(rows, dtype=np.float64)


def figures_of(rows: FloatArray) -> dict[str, float]:
    """Figures of all pairs, from what :func:`measured` returned."""
    greatest, mean, certified, rank, seconds, direct = rows.T
    return {
        "pairs": len(rows),
        "right": int((greatest <= FARTHEST).sum()),
        "direct": int((direct <= FARTHEST).sum()),
        "mean": float(mean.mean()),
        "median": float(np.median(mean)),
        "proven": int(certified.sum()),
        "overruled": int((rank > 1).sum()),
        "seconds": float(np.median(seconds)),
    }


def main() -> None:
    """Match all pairs within classes with each number of points, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--points", type=int, nargs="+", default=_POINTS)
    pair_options(parser, classes=len(CLASSES))
    parser.add_argument("--both", action="store_true", help="match each pair both ways")
    parser.add_argument(
        "--orientation",
        action=argparse.BooleanOptionalAction,
        default=MatchOptions().orientation,
        help="tell left from right",
    )
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    pairs += [(target, source) for source, target in pairs] if arguments.both else []
    for pair in pairs:
        for one in pair:
            one.shape.spectrum()
    match(pairs[0][0].shape, pairs[0][1].shape, MatchOptions(points=16))  # compiles
    figures: dict[str, dict[str, float]] = {}
    heads = "pairs", "right", "direct", "mean", "median", "proven", "overruled", "s"
    print(f"{'points':>6}" + "".join(f"{head:>10}" for head in heads))
    for points in arguments.points:
        options = MatchOptions(points=points, orientation=arguments.orientation)
        found = figures[str(points)] = figures_of(measured(pairs, options))
        print(
            f"{points:6}{found['pairs']:10}{found['right']:10}{found['direct']:10}"
            f"{found['mean']:10.4f}{found['median']:10.4f}{found['proven']:10}{found['overruled']:10}"
            f"{found['seconds']:10.3f}",
            flush=True,
        )
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
