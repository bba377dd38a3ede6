"""Minimax correspondences and Gromov-Hausdorff distances: ``python -m bench.minimax``.

For all pairs of the shapes of a folder, or of generated ones, of a class or not, the share that is
proven within a limit of work, the seconds, and the greatest gap: the injective correspondence of N
samples into 1.5 N, and the Gromov-Hausdorff distance of N samples of each.
"""

import time
from collections.abc import Callable
from itertools import combinations

import numpy as np

from bench.collection import collection, require
from bench.command_line import command_line, parsed, print_json
from solver.arrays import FloatArray, IntArray
from solver.labelling import Solution
from solver.optimisation.exact import gromov_hausdorff_distance, minimax_correspondence

_PROBLEMS: dict[str, tuple[Callable[..., Solution[IntArray]], float]] = {
    "injective": (minimax_correspondence, 1.5),
    "gromov_hausdorff": (gromov_hausdorff_distance, 1.0),
}
"""Solver of each problem, and target samples for each source sample."""


def solve_pairs(
    problem: str, distances: list[FloatArray], points: int, seconds: float
) -> dict[str, float]:
    """Solve a problem for all pairs of shapes.

    Parameters
    ----------
    problem
        One of `_PROBLEMS`.
    distances
        Metrics of the shapes among enough samples, farthest first.
    points
        Number N of samples.
    seconds
        Limit of the work of each pair.

    Returns
    -------
    Share proven, median and greatest seconds, greatest relative gap.
    """
    solve, oversampling = _PROBLEMS[problem]
    targets = int(np.ceil(oversampling * points))
    gaps, times = [], []
    for source, target in combinations(distances, 2):
        started = time.perf_counter()
        found = solve(source[:points, :points], target[:targets, :targets], seconds=seconds)
        times.append(time.perf_counter() - started)
        gaps.append(found.gap if not found.certified else 0.0)
    return {
        "share": float(np.mean(np.array(gaps) == 0.0)),
        "median_seconds": float(np.median(times)),
        "most_seconds": float(np.max(times)),
        "worst_gap": float(np.max(gaps)),
    }


def main() -> None:
    """Print a line for each metric, number of points, and problem."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--points", type=int, nargs="+", default=[8, 12, 16, 24, 32])
    parser.add_argument("--seconds", type=float, default=1.0, help="limit of each pair's work")
    parser.add_argument("--every", type=int, default=1, help="take every n-th shape only")
    arguments = parsed(parser)
    shapes = [one.shape for one in collection(arguments.data, classes=2)[:: arguments.every]]
    require(parser, shapes[1:])
    samples = int(np.ceil(1.5 * max(arguments.points)))
    triangle = np.ones((3, 3)) - np.eye(3)
    for solve, _ in _PROBLEMS.values():
        solve(triangle, triangle)  # compiles
    figures = {}
    for metric in ("geodesic", "commute_time"):
        distances = [one.sampling(metric, samples).distances for one in shapes]
        for points in arguments.points:
            for problem in _PROBLEMS:
                found = solve_pairs(problem, distances, points, arguments.seconds)
                figures[f"{metric}_{problem}_{points}"] = found
                print(
                    f"{metric:14}{problem:18}{points:4} points: {100 * found['share']:6.1f} %"
                    f" proven, {found['median_seconds']:.3f} s, at most"
                    f" {found['most_seconds']:.2f} s, gap {100 * found['worst_gap']:.1f} %",
                    flush=True,
                )
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
