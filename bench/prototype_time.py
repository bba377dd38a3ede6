"""Time of a match with a prototype beside one of two shapes: ``python -m bench.prototype_time``.

A prototype of generated humans is matched with other people and with figures outside of its family,
and so is one human of standard proportions, with as many points and all else by default. Spectra
are known to both.
Both are matched without orientation, and with it, which is the prototype's default.
Times are of whole matches, and of the processor, which counts what others do meanwhile the least:
when all other structures of the shapes are known as well, the least of three without orientation,
and when they are not. Each ratio is of the sums over all figures, or the median of theirs; a figure
is matched all ways one after the other, and every second one in the opposite order. `--data` adds
real bodies.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from bench.bodies import generated_humans
from bench.collection import read_collection
from bench.command_line import command_line, parsed, print_json
from bench.figure6 import learn
from bench.humans import human_family, unfamiliar_figures
from solver.arrays import FloatArray
from solver.control import Control
from solver.matching import COARSE_POINTS, Level, Match, MatchOptions, SampledStructure, match
from solver.optimisation.exact import m_best_solutions
from solver.prototype import Prototype, match_prototype
from solver.prototype.matching import sample_target
from solver.shape import Shape

POINTS = 8, 10, 12, 16, 24, 32
_WAYS, _KNOWN = ("plain", "oriented"), ("known", "unknown")
_BODIES = "michael", "gorilla"
_REPETITIONS = 3
_SEED = 2


def fresh(shape: Shape) -> Shape:
    """Return a shape of which nothing is known but its spectrum."""
    return Shape(shape.mesh, shape.spectrum())


def measured(
    prototype: Prototype, source: Shape, target: Shape, points: int, turn: int
) -> tuple[FloatArray, list[bool]]:
    """Times of the kinds of matches of one target.

    Returns
    -------
    seconds
        (2, 2, 2) without and with orientation, of two shapes and of the prototype, with structures
        known and unknown.
    certified
        Whether the answers without orientation are proven: of two shapes, and of the prototype.
    """
    seconds, certified = np.zeros((2, 2, 2)), [False, False]
    kinds = [(oriented, probabilistic) for oriented in (0, 1) for probabilistic in (0, 1)]
    for oriented, probabilistic in kinds if turn % 2 == 0 else kinds[::-1]:
        options = MatchOptions(points=points, orientation=bool(oriented))
        here, there = fresh(source), fresh(target)
        solve: Callable[[], Match] = (
            partial(match_prototype, prototype, there, options)
            if probabilistic
            else partial(match, here, there, options)
        )
        seconds[oriented, probabilistic, 1], answer = _timed(solve)
        again = [_timed(solve)[0] for _ in range(1 if oriented else _REPETITIONS)]
        seconds[oriented, probabilistic, 0] = min(again)
        if not oriented:
            certified[probabilistic] = answer.certified
    return seconds, certified


def _timed(solve: Callable[[], Match]) -> tuple[float, Match]:
    started = time.process_time()
    answer = solve()
    return time.process_time() - started, answer


def compare(
    prototype: Prototype, source: Shape, targets: Sequence[Shape], points: int
) -> dict[str, float]:
    """Compare both kinds of matches on all targets, and show it as a row."""
    measured(prototype, source, targets[0], points, 0)  # it compiles
    rows, proofs = zip(
        *(measured(prototype, source, target, points, turn) for turn, target in enumerate(targets)),
        strict=True,
    )
    total, middle = np.sum(rows, axis=0), np.median(rows, axis=0) * 1e3
    ratios, proven = total[:, 1] / total[:, 0], np.mean(proofs, axis=0)
    medians = np.median([row[:, 1] / row[:, 0] for row in rows], axis=0)
    found = {"points": points}
    for oriented, name in enumerate(_WAYS):
        for unknown, known in enumerate(_KNOWN):
            kind = f"{name}_{known}"
            found[f"{kind}_deterministic_ms"] = middle[oriented, 0, unknown]
            found[f"{kind}_probabilistic_ms"] = middle[oriented, 1, unknown]
            found[f"{kind}_ratio"] = ratios[oriented, unknown]
            found[f"{kind}_median_ratio"] = medians[oriented, unknown]
    found["deterministic_proven"], found["probabilistic_proven"] = proven
    found["default_over_deterministic"] = total[1, 1, 1] / total[0, 0, 1]
    print(f"{points:6}", end="")
    for oriented, unknown in np.ndindex(2, 2):
        two, prototypes = middle[oriented, :, unknown]
        ratio, median = ratios[oriented, unknown], medians[oriented, unknown]
        print(f"{two:9.0f}{prototypes:10.0f}{ratio:7.2f}{median:7.2f}", end="")
    print(f"{found['default_over_deterministic']:9.1f}{proven[0]:8.0%}{proven[1]:7.0%}", flush=True)
    return {name: float(value) for name, value in found.items()}


def enumeration_ratio(prototype: Prototype, source: Shape, targets: Sequence[Shape]) -> float:
    """Time of enumerating eight solutions of (6) over that of (5), on the same points and samples.

    Each is measured on every target, in turn, the making of its problem included. There are as many
    points as the coarsest level of a match has.
    """
    options = MatchOptions(points=10, coarse_points=10)
    points, metric = prototype.vertices[:10], prototype.distances[0].metric
    seconds = np.zeros(2)
    for turn, target in enumerate((targets[0], *targets)):
        (likely,), _ = sample_target(prototype, target, options, Control())
        here = SampledStructure(
            points, source.metric(metric).between(points), source.descriptor("si_hks", points)
        )
        there = replace(
            likely.target, descriptors=target.descriptor("si_hks", likely.target.vertices)
        )
        weights = likely.beta, likely.first_order_weight, likely.occlusion_cost
        usual = Level(0, metric, likely.descriptor, here, there, *weights)
        for place, level in enumerate((usual, likely)):
            started = time.process_time()
            m_best_solutions(level.problem(level.all_candidates()), 8)
            seconds[place] += time.process_time() - started
        if turn == 0:
            seconds[:] = 0.0  # it compiled
    return float(seconds[1] / seconds[0])


def ratio_by_geodesics(prototype: Prototype, source: Shape, targets: Sequence[Shape]) -> float:
    """Time of matches of eight points over that of two shapes that are measured in the same way.

    Of neither is anything known but spectra.
    """
    options = MatchOptions(points=8, orientation=False)
    same = MatchOptions(points=8, metric=("geodesic",), orientation=False)
    seconds = np.zeros(2)
    for turn, target in enumerate((targets[0], *targets)):
        seconds[0] += _timed(partial(match, fresh(source), fresh(target), same))[0]
        seconds[1] += _timed(partial(match_prototype, prototype, fresh(target), options))[0]
        if turn == 0:
            seconds[:] = 0.0  # it compiled
    return float(seconds[1] / seconds[0])


def main() -> None:
    """Measure both kinds of matches side by side, by number of points."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--examples", type=int, default=40)
    parser.add_argument("--figures", type=int, default=12)
    parser.add_argument("--points", type=int, nargs="*", default=list(POINTS))
    arguments = parsed(parser)
    family = human_family(arguments.examples - 1)
    prototype = learn(family, arguments.examples, 5, max(arguments.points))
    figures = [one.shape for one in unfamiliar_figures(family, arguments.figures, _SEED)]
    people = [body.clean for body in generated_humans(prototype, family)][: arguments.figures]
    groups = {
        "generated people": (family.reference, people),
        "unusual figures": (family.reference, figures),
    }
    if arguments.data:
        bodies = [one for one in read_collection(arguments.data) if one.category in _BODIES]
        for body in _BODIES:
            group = [one.shape for one in bodies if one.category == body]
            if len(group) > 1:
                groups[body] = group[0], group[1:]
    found: dict[str, object] = {}
    for name, (source, targets) in groups.items():
        print(
            f"\n{name}: ms of two shapes and of the prototype, ratio of sums, median ratio; then"
            " the default over two shapes without orientation, and proven without"
        )
        heads = [f"{way}, structures {known}" for way in _WAYS for known in _KNOWN]
        print(" " * 6 + "".join(f"{head:>33}" for head in heads))
        found[name] = [compare(prototype, source, targets, n) for n in arguments.points]
    ratio = ratio_by_geodesics(prototype, family.reference, figures)
    print(f"\nEight points take {ratio:.2f} times as long as of two shapes by geodesic distances")
    found["ratio_by_geodesics"] = ratio
    if prototype.points >= COARSE_POINTS:
        ratio = enumeration_ratio(prototype, family.reference, figures)
        print(f"\nEight solutions of (6) take {ratio:.2f} times as long as those of (5)")
        found["enumeration_ratio"] = ratio
    print_json(arguments, found)


if __name__ == "__main__":
    main()
