"""Accuracy of refinement between vertices by GMDS: ``python -m bench.refinement``.

Geodesic error over √area of the matched vertices, and of the points that ``refine="gmds"`` finds
between vertices, per pair of shapes of a class; each against the better of the direct and the
mirrored truth.
"""

import time

import numpy as np

from bench.collection import known_pairs, pair_options
from bench.command_line import command_line, parsed, print_json
from bench.surface_error import better_errors
from solver.gmds import SurfacePoints
from solver.matching import MatchOptions, match


def figures_of(rows: list[tuple[float, float, float, float]]) -> dict[str, float]:
    """Figures of all pairs, from the errors before and after, and the seconds of either step."""
    before, after, matching, refining = np.array(rows).mean(axis=0)
    return {
        "pairs": len(rows),
        "matched": float(before),
        "refined": float(after),
        "lowered_by": float(1.0 - after / before),
        "seconds_matching": float(matching),
        "seconds_refining": float(refining),
    }


def main() -> None:
    """Match and refine the pairs, print a table."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--points", type=int, default=64)
    pair_options(parser, classes=3)
    arguments = parsed(parser)
    pairs = known_pairs(parser, arguments)
    options = MatchOptions(points=arguments.points, refine="gmds")
    rows = []
    print(f"{'pair':34}{'matched':>9}{'refined':>9}{'hypothesis':>12}{'match s':>9}{'refine s':>9}")
    for source, target in pairs:
        source.shape.spectrum()
        target.shape.spectrum()
        started = time.perf_counter()
        found = match(source.shape, target.shape, options)
        seconds = time.perf_counter() - started
        refined = found.refinement
        assert refined is not None
        here = source.shape.mesh.vertices_of(found.best.source)
        there = target.shape.mesh.vertices_of(found.best.target)
        matched = SurfacePoints.at_vertices(target.shape.surface, there)
        before, after = (
            float(better_errors(source, target, here, points)[1].mean())
            for points in (matched, refined.points)
        )
        refining = found.timings["refinement between vertices"]
        rows.append((before, after, seconds - refining, refining))
        print(
            f"{source.name + ' ' + target.name:34}{before:9.4f}{after:9.4f}"
            f"{refined.hypothesis:12}{rows[-1][2]:9.2f}{refining:9.2f}",
            flush=True,
        )
    figures = figures_of(rows)
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in figures.items()))
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
