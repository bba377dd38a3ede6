"""Accuracy of dense maps: ``python -m bench.dense``.

Mean geodesic error over √area of all vertices' images with known truth, direct and against the
better of the direct and the mirrored truth, per pair of shapes of a class.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

from bench.collection import KnownShape, collection, default_folder, pairs_of_known_truth
from bench.surface_error import surface_errors, truths_of
from solver.arrays import FloatArray, IntArray
from solver.gmds import SurfacePoints
from solver.matching import MatchOptions, match


def main() -> None:
    """Map the shapes of the pairs, print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=default_folder(), help="folder of meshes")
    parser.add_argument("--points", type=int, default=32, help="matched before")
    parser.add_argument("--every", type=int, default=1, help="take every n-th pair only")
    parser.add_argument("--compared", type=int, default=500, help="known points compared, at most")
    parser.add_argument("--json", action="store_true", help="end with one line of JSON")
    arguments = parser.parse_args()
    pairs = pairs_of_known_truth(collection(arguments.data, classes=3))
    options = MatchOptions(points=arguments.points, dense=True)
    rows = []
    print(f"{'pair':34}{'direct':>9}{'better':>9}{'hypothesis':>12}{'match s':>9}{'map s':>9}")
    for source, target in pairs[:: arguments.every]:
        source.shape.spectrum()
        target.shape.spectrum()
        started = time.perf_counter()
        found = match(source.shape, target.shape, options)
        seconds = time.perf_counter() - started
        dense = found.dense
        assert dense is not None
        direct, better = mean_errors(source, target, dense.target, arguments.compared)
        mapping = found.timings["dense map"]
        rows.append((direct, better, seconds - mapping, mapping))
        print(
            f"{source.name + ' ' + target.name:34}{direct:9.4f}{better:9.4f}"
            f"{dense.hypothesis:12}{seconds - mapping:9.2f}{mapping:9.2f}",
            flush=True,
        )
    figures = summary(np.array(rows))
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in figures.items()))
    if arguments.json:
        print(json.dumps(figures))


def mean_errors(
    source: KnownShape, target: KnownShape, images: IntArray, most: int
) -> tuple[float, float]:
    """Mean error of known points, direct, and against the better truth.

    Parameters
    ----------
    source, target
        The shapes, of one class, with known truth.
    images
        (V,) the user's number of the target vertex that each vertex of the source goes to.
    most
        How many points are compared, evenly among those known.
    """
    assert source.truth is not None
    vertices = source.truth[:: max(len(source.truth) // most, 1)]
    there = target.shape.mesh.vertices_of(images[vertices])
    points = SurfacePoints.at_vertices(target.shape.surface, there)
    truths = truths_of(source, target, vertices)
    errors = [float(surface_errors(target, points, truth).mean()) for truth in truths]
    return errors[0], min(errors)


def summary(rows: FloatArray) -> dict[str, float]:
    """Figures of the (P, 4) rows: errors, direct and better, seconds of matching and mapping."""
    direct, better, matching, mapping = rows.T
    return {
        "pairs": len(rows),
        "direct": float(direct.mean()),
        "best": float(better.mean()),
        "median_best": float(np.median(better)),
        "share_over_0_1": float((better > 0.1).mean()),
        "mirrored": float((better < 0.8 * direct).mean()),
        "seconds_matching": float(matching.mean()),
        "seconds_mapping": float(mapping.mean()),
    }


if __name__ == "__main__":
    main()
