"""Bounds, proofs, answers and times of the optimisation: ``python -m bench.solver``.

Five tables, on random problems: points in space and a noisy copy of some of them, in another order.

1. The gap that each combination of subproblems leaves within a time limit, and the time to 1e-4.
2. How often and how fast the optimum is proven, by the front solver.
3. Its answers beside the best of as many local searches from random starts as fit into its time.
4. Time and memory as problems grow, with the twelve candidates a point of the finer levels.
5. Table 1 with third-order costs: signed volumes of the tetrahedra of the origin and three points.
"""

import time
import tracemalloc
from collections.abc import Callable
from functools import partial
from itertools import combinations

import numpy as np

from bench.command_line import command_line, parsed, print_json
from solver.arrays import FloatArray
from solver.control import UNLIMITED, Control, iterate
from solver.labelling import CERTIFIED_GAP, NO_TRIPLES, LabellingProblem, triple_costs
from solver.optimisation import minimise
from solver.optimisation.dual_decomposition import DualDecomposition, Subproblems
from solver.optimisation.primal import local_search

COMBINATIONS = {
    "linear, maxflow": Subproblems(source_pairs=False, target_pairs=False, maxflow=True),
    "source pairs": Subproblems(target_pairs=False),
    "source, target pairs": Subproblems(),
    "both, maxflow": Subproblems(maxflow=True),
}


_IN_TRIPLES = 8
"""Points whose triples have third-order costs."""


def instance(
    n: int,
    m: int,
    seed: int,
    noise: float,
    candidates: int | None = None,
    third_order: float = 0.0,
) -> LabellingProblem:
    """Points of m in space, n of them again with noise; all pairs or the nearest may match."""
    rng = np.random.default_rng(seed)
    target = rng.normal(size=(m, 3))
    image = rng.permutation(m)[:n]
    source = target[image] + noise * rng.normal(size=(n, 3))

    def distances(points: FloatArray) -> FloatArray:
        between: FloatArray = np.linalg.norm(points[:, None] - points[None], axis=2)
        return between

    apart = np.linalg.norm(source[:, None] - target[None], axis=2)
    count = m if candidates is None else candidates
    nearest = np.argsort(apart, axis=1)[:, :count]
    nearest[:, -1] = np.where((nearest == image[:, None]).any(axis=1), nearest[:, -1], image)
    pairs = np.stack([np.repeat(np.arange(n), count), np.sort(nearest, axis=1).ravel()], axis=1)
    rows, triples = count * np.arange(n + 1), NO_TRIPLES
    if third_order > 0.0:
        points = np.array(list(combinations(range(min(n, _IN_TRIPLES)), 3)))
        tables = []
        for triple in points:
            there = np.ix_(*(pairs[rows[x] : rows[x + 1], 1] for x in triple))
            volumes = np.linalg.det(np.stack([target[y] for y in np.broadcast_arrays(*there)], -1))
            tables.append(third_order * (np.linalg.det(source[triple].T) - volumes) ** 2)
        triples = triple_costs(rows, points, tables)
    return LabellingProblem(
        pairs.astype(np.int64),
        0.1 * rng.random(len(pairs)),
        distances(source),
        distances(target),
        triples=triples,
    )


def elapsed(work: Callable[[], object]) -> float:
    """Seconds of wall time that a call takes."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def median(values: list[float]) -> float:
    """Median."""
    return float(np.median(values))


def gaps(
    seconds: float, count: int, sizes: tuple[int, ...] = (8, 10, 16, 32), third_order: float = 0.0
) -> dict[str, float]:
    """Tables 1 and 5."""
    print(f"gap within {seconds:g} s, median of {count} (and seconds to 1e-4 where reached)")
    print(f"{'':22}" + "".join(f"{f'N = {n}':>18}" for n in sizes))
    figures = {}
    for name, subproblems in COMBINATIONS.items():
        cells = []
        for n in sizes:
            left, times = [], []
            for seed in range(count):
                problem = instance(n, n, seed, 0.3, third_order=third_order)
                method = DualDecomposition(problem, None, subproblems)
                started = time.perf_counter()
                found = iterate(method, UNLIMITED, Control().within(seconds)).state
                times.append(time.perf_counter() - started)
                left.append(found.gap)
            order = "third_order_" if third_order > 0.0 else ""
            figures[f"gap_{order}{name}_{n}"] = median(left)
            reached = [t for t, gap in zip(times, left, strict=True) if gap <= CERTIFIED_GAP]
            done = f"({median(reached):.2f} s)" if 2 * len(reached) > count else ""
            cells.append(f"{100 * median(left):7.2f} % {done:>8}")
        print(f"{name:22}" + "".join(f"{cell:>18}" for cell in cells), flush=True)
    return figures


def proofs(count: int) -> dict[str, float]:
    """Table 2."""
    print("\nthe front solver, square problems: proven, and milliseconds (median, worst)")
    figures = {}
    for n, noise in ((8, 0.3), (10, 0.3), (10, 1.0), (16, 0.3), (16, 1.0), (16, 2.0), (20, 0.5)):
        times, proven, fast = [], 0, 0
        for seed in range(count):
            problem = instance(n, n, seed, noise)
            times.append(elapsed(partial(minimise, problem)))
            proven += minimise(problem).certified
            fast += minimise(problem, control=Control().within(0.5)).gap <= 0.01
        print(
            f"  N = {n:3} noise {noise:3}: {proven:3} of {count}"
            f"{1e3 * median(times):10.1f}{1e3 * max(times):10.1f}"
            f"   within 1 % after 0.5 s: {fast} of {count}",
            flush=True,
        )
        figures[f"proven_{n}_{noise}"] = proven / count
        figures[f"within_1_percent_in_half_a_second_{n}_{noise}"] = fast / count
    return figures


def answers(count: int) -> dict[str, float]:
    """Table 3."""
    print("\nanswers at N = 32 beside local searches from random starts in equal time")
    figures = {}
    for noise in (0.3, 0.5, 1.0, 2.0):
        ratios = []
        for seed in range(count):
            problem = instance(32, 32, seed, noise)
            started = time.perf_counter()
            ours = minimise(problem, iterations=300).value
            until = 2.0 * time.perf_counter() - started
            rng, best = np.random.default_rng(seed), np.inf
            while time.perf_counter() < until:
                best = min(best, problem.energy(local_search(problem, rng.permutation(32))))
            ratios.append(ours / best)
        wins = sum(ratio <= 1.0 + 1e-9 for ratio in ratios) / count
        print(
            f"  noise {noise:3}: as good or better on {100 * wins:.0f} %,"
            f" ratio of energies {min(ratios):.4f} to {max(ratios):.4f}",
            flush=True,
        )
        figures[f"as_good_as_multistart_{noise}"] = wins
    return figures


def scaling() -> dict[str, float]:
    """Table 4."""
    print("\n12 candidates a point, M = 4 N: milliseconds an iteration, MB, gap after 100")
    figures = {}
    for n in (16, 32, 64, 128, 256):
        problem = instance(n, 4 * n, 0, 0.1, 12)
        iterate(DualDecomposition(problem), 3, Control())
        tracemalloc.start()
        method = DualDecomposition(problem)
        found = iterate(method, 3, Control()).state
        memory = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
        each = elapsed(partial(iterate, method, 97, Control(), found)) / 97
        print(f"  N = {n:3}: {1e3 * each:9.2f}{memory:9.1f}{100 * found.gap:9.2f} %", flush=True)
        figures[f"ms_per_iteration_{n}"] = 1e3 * each
        figures[f"megabytes_{n}"] = memory
    return figures


def main() -> None:
    """Print the tables."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=10, help="problems of each kind")
    parser.add_argument("--seconds", type=float, default=1.0, help="limit of table 1")
    arguments = parsed(parser)
    minimise(instance(17, 17, 0, 0.5), iterations=150)  # compiles
    figures = gaps(arguments.seconds, max(arguments.count // 2, 1))
    figures |= proofs(arguments.count)
    figures |= answers(max(arguments.count // 2, 1))
    figures |= scaling()
    print("\nwith third-order costs:", end=" ")
    figures |= gaps(arguments.seconds, max(arguments.count // 2, 1), (8, 10), 0.1)
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
