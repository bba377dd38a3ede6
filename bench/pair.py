"""Time of a match of eight points beside its eigensolves: ``python -m bench.pair``.

Three times are taken in turn, pair by pair, in one process: both spectra alone, a match that has to
compute them (cold), and the same match when they are known (warm).
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

from bench.collection import collection, pairs_within_classes, require
from bench.command_line import command_line, parsed, print_json
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh
from solver.shape import Shape


def seconds(work: Callable[[], object]) -> float:
    """Wall time of a call."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def times_of(
    source: TriangleMesh, target: TriangleMesh, options: MatchOptions
) -> tuple[float, float, float]:
    """Seconds of both eigensolves, of a cold match, and of a warm one, on fresh shapes."""
    alone = seconds(lambda: (Shape(source).spectrum(), Shape(target).spectrum()))
    cold = seconds(lambda: match(Shape(source), Shape(target), options))
    known = Shape(source).spectrum(), Shape(target).spectrum()
    warm = seconds(lambda: match(Shape(source, known[0]), Shape(target, known[1]), options))
    return alone, cold, warm


def main() -> None:
    """Time the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--most", type=int, default=12, help="pairs to time")
    parser.add_argument(
        "--orientation",
        action=argparse.BooleanOptionalAction,
        default=MatchOptions().orientation,
        help="tell left from right",
    )
    arguments = parsed(parser)
    options = MatchOptions(points=8, orientation=arguments.orientation)
    shapes = collection(arguments.data, 5000)
    pairs = pairs_within_classes(shapes)
    chosen = pairs[:: max(len(pairs) // arguments.most, 1)][: arguments.most]
    require(parser, chosen)
    times_of(chosen[0][0].shape.mesh, chosen[0][1].shape.mesh, options)  # compiles
    rows = []
    print(f"{'pair':30}{'spectra s':>11}{'cold s':>9}{'warm s':>9}{'cold/sp.':>10}{'warm/sp.':>10}")
    for source, target in chosen:
        alone, cold, warm = times_of(source.shape.mesh, target.shape.mesh, options)
        rows.append((alone, cold, warm))
        name = f"{source.name} {target.name}"
        print(
            f"{name:30}{alone:11.3f}{cold:9.3f}{warm:9.3f}{cold / alone:10.2f}{warm / alone:10.2f}",
            flush=True,
        )
    alone, cold, warm = np.array(rows).T
    figures = {
        "pairs": len(rows),
        "cold_over_spectra": float(np.median(cold / alone)),
        "warm_over_spectra": float(np.median(warm / alone)),
    }
    print("\nmedian ratios: " + "   ".join(f"{k} {v:.3g}" for k, v in figures.items()))
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
