"""Left and right by third-order terms alone: ``python -m bench.third_order``.

For all pairs within a class, of a folder or generated, and without any registration:

1. how much third-order distortion the true maps of the samples have, and their mirror images;
2. the least energy over all pairs of samples, without and with the third-order term, its proof, and
   whether it is *direct*: nearer to the direct truth than to the mirrored one, and its mean error
   at most 0.25. An answer may also be nearer to the mirror image, or near neither.
"""

import time
from dataclasses import dataclass, replace

import numpy as np

from bench.collection import KnownShape, known_pairs, pair_options, require
from bench.command_line import command_line, parsed, print_json
from bench.surface_error import FARTHEST, truths_of
from solver.arrays import IntArray
from solver.control import Control
from solver.matching import MatchOptions, ThirdOrderTerm, build_level, build_varadhan_level
from solver.optimisation import minimise

VARADHAN = "varadhan"
"""Metric of the level at which a match decides: the Varadhan approximation of geodesic distance."""
_SECONDS = 60.0
"""Limit of one proof."""


@dataclass(frozen=True)
class Proven:
    """Least energy of a pair, and where it leads.

    Parameters
    ----------
    direct, mirrored
        Mean errors over √area, against either truth.
    certified
        Whether it is proven.
    seconds
        Time of the optimisation.
    """

    direct: float
    mirrored: float
    certified: bool
    seconds: float

    @property
    def is_direct(self) -> bool:
        """Return whether the answer is direct."""
        return self.direct < self.mirrored and self.direct <= FARTHEST

    @property
    def is_mirrored(self) -> bool:
        """Return whether the answer is the mirror image."""
        return self.mirrored <= self.direct and self.mirrored <= FARTHEST


def distortion(
    source: KnownShape, target: KnownShape, samples: IntArray, images: IntArray
) -> float:
    """Third-order distortion of a map, relative to the mean square of the volumes."""
    term = ThirdOrderTerm.between(source.shape, target.shape, (samples, images), 1.0)
    there = term.target[tuple(term.points.T)]
    return float(np.mean((term.source - there) ** 2)) / term.unit**2


def least_energy(
    source: KnownShape, target: KnownShape, size: tuple[int, int], metric: str, weight: float
) -> Proven:
    """Prove the least energy of samples of two shapes, with a weight of the third-order term."""
    if metric == VARADHAN:
        options = MatchOptions().settled(1.0)
        level = build_varadhan_level(source.shape, target.shape, 0, size, options)
    else:
        options = MatchOptions(metric=(metric,)).settled(1.0)
        level = build_level(source.shape, target.shape, 0, size, options)
    samples = level.source.vertices, level.target.vertices
    if weight > 0.0:
        term = ThirdOrderTerm.between(source.shape, target.shape, samples, weight)
        level = replace(level, third_order=term)
    problem = level.problem(level.all_candidates())
    started = time.perf_counter()
    control = Control().within(_SECONDS)
    found = minimise(problem, search_seconds=_SECONDS, control=control)
    seconds = time.perf_counter() - started
    kept, truths = truths_of(source, target, samples[0])
    distances = target.shape.metric("geodesic").distances(samples[1][found.answer[kept]])
    rows = np.arange(len(distances))
    errors = [float(distances[rows, truth].mean()) / target.shape.size for truth in truths]
    return Proven(errors[0], errors[1], found.certified, seconds)


def figures_of(rows: list[Proven]) -> dict[str, float]:
    """Shares of direct, mirrored and proven answers, and seconds."""
    seconds = [row.seconds for row in rows]
    return {
        "direct": float(np.mean([row.is_direct for row in rows])),
        "mirrored": float(np.mean([row.is_mirrored for row in rows])),
        "within_0_1": float(np.mean([row.direct <= 0.1 for row in rows])),
        "proven": float(np.mean([row.certified for row in rows])),
        "median_seconds": float(np.median(seconds)),
        "most_seconds": float(np.max(seconds)),
    }


def main() -> None:
    """Measure the pairs, print the tables."""
    parser = command_line(__doc__, data=True)
    pair_options(parser, classes=6)
    parser.add_argument("--points", type=int, default=12)
    parser.add_argument("--targets", type=int, default=48, help="samples of the target")
    parser.add_argument("--metric", default=VARADHAN)
    parser.add_argument("--weights", type=float, nargs="+", default=[0.0, 0.03])
    arguments = parsed(parser)
    pairs = [
        (source, target)
        for source, target in known_pairs(parser, arguments)
        if target.symmetric_truth is not None
    ]
    require(parser, pairs)
    for shape in {id(shape): shape for pair in pairs for shape in pair}.values():
        shape.shape.spectrum()
    maps = []
    for source, target in pairs:
        samples = source.shape.sampling("commute_time", arguments.points).indices
        kept, truths = truths_of(source, target, samples)
        maps.append([distortion(source, target, samples[kept], truth) for truth in truths])
    direct, mirrored = np.array(maps).T
    print(f"{len(pairs)} pairs; third-order distortion of the true maps, median and greatest")
    print(f"  direct {np.median(direct):.2f} {direct.max():.2f}", end="")
    print(f"   mirrored, median and least {np.median(mirrored):.2f} {mirrored.min():.2f}", end="")
    print(f"   direct below mirrored {(direct < mirrored).mean():.1%}\n", flush=True)
    figures: dict[str, float] = {"less_distorted": float((direct < mirrored).mean())}
    size = arguments.points, arguments.targets
    for weight in arguments.weights:
        rows = [least_energy(*pair, size, arguments.metric, weight) for pair in pairs]
        found = figures_of(rows)
        print(f"weight {weight:g}: " + "   ".join(f"{k} {v:.3g}" for k, v in found.items()))
        figures |= {f"{name}_{weight:g}": value for name, value in found.items()}
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
