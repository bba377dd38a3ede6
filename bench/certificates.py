"""Certificates over the whole search space: ``python -m bench.certificates [FILE...]``.

Matches all pairs within a class, of a folder or generated, and prints for each the energy of the
answer, the least energy over all target samples, the relative gap that is left below it, the
seconds of the proof, and the memory of one more proof. The structures are cached from pair to pair.
The work of a proof is not limited but by its time; ``--work`` sets a limit as the service does.

Of ``.dd`` files, which hold public graph matching instances, all assignments of the file are the
search space. They take the place of the pairs, or are added to those of a folder that is named.
"""

import argparse
import math
import resource
import sys
import tracemalloc
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from bench.collection import KnownShape, Pair, collection, pairs_within_classes, require
from bench.command_line import command_line, default_folder, parsed, print_json
from bench.dd import SMALL, solve
from bench.dd_format import parse_dd, read_dd
from solver.control import Control
from solver.labelling import CERTIFIED_GAP, relative_gap
from solver.matching import CANDIDATES, MatchOptions, match

_UNLIMITED = 86400.0
"""Work beyond any time limit, in seconds."""
_MEGABYTE = 1e6
_UNIT_OF_PEAK = 1 if sys.platform == "darwin" else 1024
"""Bytes in the unit of the peak of resident memory."""


@dataclass(frozen=True)
class Certificate:
    """Certificate of a pair of shapes, or of an instance.

    Parameters
    ----------
    pair
        Names of the shapes, or of the file.
    points, target_points
        Numbers of points, N and M.
    candidates
        Number of pairs of them that are allowed.
    answer
        Energy of the answer.
    energy
        Least energy that is known over all candidates.
    gap
        Relative distance of the lower bound from it.
    seconds
        Time of the proof.
    rest
        Time of the rest of the match.
    megabytes
        Greatest memory of a match with the proof, without what was cached before; ``None`` where
        it was not measured.
    """

    pair: str
    points: int
    target_points: int
    candidates: int
    answer: float
    energy: float
    gap: float
    seconds: float
    rest: float
    megabytes: float | None

    @property
    def excess(self) -> float:
        """Relative distance of the least energy from that of the answer."""
        return relative_gap(self.answer, self.energy)

    @property
    def digits(self) -> float:
        """Decimal logarithm of the number of injective maps of the fewer points into the others."""
        few, many = sorted((self.points, self.target_points))
        return (math.lgamma(many + 1) - math.lgamma(many - few + 1)) / math.log(10.0)


def certificate(
    source: KnownShape, target: KnownShape, options: MatchOptions, *, memory: bool
) -> Certificate:
    """Match a pair and prove the least energy over all samples.

    Parameters
    ----------
    source, target
        The shapes.
    options
        Of the match; its time limit is that of the proof.
    memory
        Whether to match a second time, and trace memory.
    """
    found = match(source.shape, target.shape, options)
    proof = found.proof
    assert proof is not None
    return Certificate(
        pair=f"{source.name} {target.name}",
        points=len(proof.optimum.source) + len(proof.optimum.unmatched),
        target_points=proof.target_points,
        candidates=proof.candidates,
        answer=found.best.energy,
        energy=proof.energy,
        gap=proof.gap,
        seconds=proof.seconds,
        rest=found.timings["total"] - proof.seconds,
        megabytes=_traced(lambda: match(source.shape, target.shape, options), memory),
    )


def instance_certificate(path: Path, seconds: float, *, memory: bool) -> Certificate:
    """Solve a ``.dd`` file within a time limit.

    Parameters
    ----------
    path
        The file, possibly compressed.
    seconds
        Limit of the time.
    memory
        Whether to solve it a second time, and trace memory.
    """
    problem = read_dd(path)
    control = Control().timed()
    with control.stage("proof"):
        found = solve(problem, seconds, CERTIFIED_GAP)
    return Certificate(
        pair=path.name,
        points=problem.n_sources,
        target_points=problem.n_targets,
        candidates=problem.n_candidates,
        answer=found.value,
        energy=found.value,
        gap=found.gap,
        seconds=control.timings["proof"],
        rest=0.0,
        megabytes=_traced(lambda: solve(problem, seconds, CERTIFIED_GAP), memory),
    )


def _traced(run: Callable[[], object], memory: bool) -> float | None:
    """Greatest memory of a further run, in megabytes; ``None`` if it is not asked for."""
    if not memory:
        return None
    tracemalloc.start()
    run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / _MEGABYTE


def figures_of(certificates: Sequence[Certificate]) -> dict[str, float | None]:
    """Summarise certificates: shares of proofs, search space, seconds, worst gap, memory.

    The peak is that of the process so far: libraries, shapes and their structures included.
    """
    gaps = np.array([one.gap for one in certificates])
    seconds = np.array([one.seconds for one in certificates])
    excess = np.array([one.excess for one in certificates])
    megabytes = [one.megabytes for one in certificates if one.megabytes is not None]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _UNIT_OF_PEAK
    return {
        "pairs": len(certificates),
        "share_1e4": float((gaps <= CERTIFIED_GAP).mean()),
        "share_1e2": float((gaps <= 1e-2).mean()),
        "median_candidates": float(np.median([one.candidates for one in certificates])),
        "median_digits": float(np.median([one.digits for one in certificates])),
        "median_seconds": float(np.median(seconds)),
        "most_seconds": float(seconds.max()),
        "worst_gap": float(gaps.max()),
        "median_seconds_of_the_rest": float(np.median([one.rest for one in certificates])),
        "answers_of_least_energy": float((excess <= CERTIFIED_GAP).mean()),
        "most_megabytes": max(megabytes, default=None),
        "peak_megabytes": peak / _MEGABYTE,
    }


def _of_pairs(pairs: list[Pair], arguments: argparse.Namespace) -> Iterator[Certificate]:
    """Certificates of all pairs."""
    first, second = pairs[0]
    warm = MatchOptions(points=arguments.points, proof=CANDIDATES)
    for one in {shape.name: shape for pair in pairs for shape in pair}.values():
        match(one.shape, one.shape, warm)  # fills the caches, and compiles
    options = MatchOptions(
        points=arguments.points, proof_work=arguments.work, time_limit=arguments.seconds
    )
    match(first.shape, second.shape, MatchOptions(points=8))
    for place, (source, target) in enumerate(pairs):
        yield certificate(source, target, options, memory=place < arguments.memory)


def _of_files(arguments: argparse.Namespace) -> Iterator[Certificate]:
    """Certificates of ``.dd`` files."""
    solve(parse_dd(SMALL), 60.0, 0.0)  # compiles
    for place, path in enumerate(arguments.files):
        yield instance_certificate(path, arguments.seconds, memory=place < arguments.memory)


def main() -> None:
    """Print a line for each pair or instance, and a summary."""
    parser = command_line(__doc__)
    parser.add_argument("files", type=Path, nargs="*", metavar="FILE", help=".dd, .dd.xz, ...")
    parser.add_argument("--data", type=Path, help="folder of meshes")
    parser.add_argument("--points", type=int, default=32)
    parser.add_argument("--work", type=float, default=_UNLIMITED, help="limit, in nominal seconds")
    parser.add_argument("--seconds", type=float, default=20.0, help="limit of a match or a file")
    parser.add_argument("--every", type=int, default=1, help="take every n-th pair only")
    parser.add_argument("--memory", type=int, default=2, help="pairs to trace memory of")
    arguments = parsed(parser)
    of_pairs = arguments.data is not None or not arguments.files
    pairs = []
    if of_pairs:
        shapes = collection(arguments.data or default_folder())
        pairs = pairs_within_classes(shapes)[:: arguments.every]
        require(parser, pairs)
    certificates = []
    for found in chain(_of_files(arguments), _of_pairs(pairs, arguments) if pairs else ()):
        certificates.append(found)
        memory = "" if found.megabytes is None else f" {found.megabytes:6.0f} MB"
        print(
            f"{found.pair:34}{found.points:4} x {found.target_points:<4}{found.candidates:6}"
            f" candidates, 10^{found.digits:<3.0f} maps: answer {found.answer:8.4f}"
            f" least {found.energy:8.4f} gap {100 * found.gap:7.3f} % {found.seconds:6.2f} s"
            f" of the proof, {found.rest:5.2f} s of the rest{memory}",
            flush=True,
        )
    figures = figures_of(certificates)
    for name, value in figures.items():
        if value is not None:
            print(f"{name:28} {value:10.4f}")
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
