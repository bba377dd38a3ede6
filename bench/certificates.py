"""Certificates over all samples of the finest level: ``python -m bench.certificates``.

Matches all pairs within a class, of a folder or generated, and prints for each the energy of the
answer, the least energy over all target samples, the relative gap that is left below it, the
seconds of the proof, and the memory of one more proof. The structures are cached from pair to pair.
The work of a proof is not limited but by its time; ``--work`` sets a limit as the service does.
"""

import argparse
import json
import tracemalloc
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.collection import KnownShape, collection, default_folder, pairs_within_classes
from solver.labelling import CERTIFIED_GAP, relative_gap
from solver.matching import CANDIDATES, MatchOptions, match

_UNLIMITED = 86400.0
"""Work beyond any time limit, in seconds."""
_MEGABYTE = 1e6


@dataclass(frozen=True)
class Certificate:
    """Certificate of a pair.

    Parameters
    ----------
    pair
        Names of the shapes.
    answer
        Energy of the answer.
    energy
        Least energy that is known over all target samples.
    gap
        Relative distance of the lower bound from it.
    seconds
        Time of the proof.
    rest
        Time of the rest of the match.
    megabytes
        Greatest memory of a match with the proof, without what was cached before; NaN where it was
        not measured.
    """

    pair: str
    answer: float
    energy: float
    gap: float
    seconds: float
    rest: float
    megabytes: float

    @property
    def excess(self) -> float:
        """Relative distance of the least energy from that of the answer."""
        return relative_gap(self.answer, self.energy)


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
    assert found.proof is not None
    megabytes = float("nan")
    if memory:
        tracemalloc.start()
        match(source.shape, target.shape, options)
        megabytes = tracemalloc.get_traced_memory()[1] / _MEGABYTE
        tracemalloc.stop()
    seconds = found.proof.seconds
    return Certificate(
        f"{source.name} {target.name}",
        found.best.energy,
        found.proof.energy,
        found.proof.gap,
        seconds,
        found.timings["total"] - seconds,
        megabytes,
    )


def figures_of(certificates: list[Certificate]) -> dict[str, float]:
    """Summarise certificates: shares of proofs, seconds, worst gap, memory."""
    gaps = np.array([one.gap for one in certificates])
    seconds = np.array([one.seconds for one in certificates])
    excess = np.array([one.excess for one in certificates])
    megabytes = [one.megabytes for one in certificates if not np.isnan(one.megabytes)]
    return {
        "pairs": len(certificates),
        "share_1e4": float((gaps <= CERTIFIED_GAP).mean()),
        "share_1e2": float((gaps <= 1e-2).mean()),
        "median_seconds": float(np.median(seconds)),
        "most_seconds": float(seconds.max()),
        "worst_gap": float(gaps.max()),
        "median_seconds_of_the_rest": float(np.median([one.rest for one in certificates])),
        "answers_of_least_energy": float((excess <= CERTIFIED_GAP).mean()),
        "most_megabytes": max(megabytes, default=float("nan")),
    }


def main() -> None:
    """Print a line for each pair, and a summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=default_folder(), help="folder of meshes")
    parser.add_argument("--points", type=int, default=32)
    parser.add_argument("--work", type=float, default=_UNLIMITED, help="limit, in nominal seconds")
    parser.add_argument("--seconds", type=float, default=20.0, help="limit of a match")
    parser.add_argument("--every", type=int, default=1, help="take every n-th pair only")
    parser.add_argument("--memory", type=int, default=2, help="pairs to trace memory of")
    parser.add_argument("--json", action="store_true", help="end with one line of JSON")
    arguments = parser.parse_args()
    pairs = pairs_within_classes(collection(arguments.data))[:: arguments.every]
    first, second = pairs[0]
    warm = MatchOptions(points=arguments.points, proof=CANDIDATES)
    for one in {shape.name: shape for pair in pairs for shape in pair}.values():
        match(one.shape, one.shape, warm)  # fills the caches, and compiles
    options = MatchOptions(
        points=arguments.points, proof_work=arguments.work, time_limit=arguments.seconds
    )
    match(first.shape, second.shape, MatchOptions(points=8))
    certificates = []
    for place, (source, target) in enumerate(pairs):
        found = certificate(source, target, options, memory=place < arguments.memory)
        certificates.append(found)
        print(
            f"{found.pair:40} answer {found.answer:8.4f} least {found.energy:8.4f}"
            f" gap {100 * found.gap:7.3f} % {found.seconds:6.2f} s of the proof,"
            f" {found.rest:5.2f} s of the rest {found.megabytes:6.0f} MB",
            flush=True,
        )
    figures = figures_of(certificates)
    for name, value in figures.items():
        print(f"{name:28} {value:10.4f}")
    if arguments.json:
        print(json.dumps(figures))


if __name__ == "__main__":
    main()
