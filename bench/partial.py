"""Parts matched with whole shapes: ``python -m bench.partial``.

Without ``--data``, parts are cut out of generated people, scaled, and matched with other people;
with it, every shape of the folder that lacks known points is matched with every one that has all.
Printed are the mean geodesic error of the part's points over √area of the whole, the F1 score of
the vertices of the whole that are said to have no partner, the share of the whole that is said to
have one, and the confidence. ``--fit`` prints the weights of the confidence that fit best.
"""

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from bench.calibration import calibration, print_calibration
from bench.collection import KnownShape, default_folder, read_collection
from bench.cut import generated_part
from bench.logistic import fit_logistic
from bench.map_error import WRONG, map_error
from solver.arrays import BoolArray
from solver.matching import Match, MatchOptions, match

NEAR = 0.02
"""Distance in space over √area from a true partner within which a vertex has one."""

MEASURES = "score", "margin"


@dataclass(frozen=True)
class MatchedPart:
    """One match of a part.

    Parameters
    ----------
    name
        Of both shapes.
    error
        Mean error of the part's points.
    f1
        F1 score of the vertices of the whole without a partner.
    share, true_share
        Of the whole's vertices with a partner, found and true.
    probability, measures
        The confidence.
    seconds
        Processor time.
    """

    name: str
    error: float
    f1: float
    share: float
    true_share: float
    probability: float
    measures: dict[str, float]
    seconds: float


def pairs(folder: Path | None, count: int, first: int) -> Iterator[tuple[KnownShape, KnownShape]]:
    """Yield parts and wholes."""
    if folder is None:
        for seed in range(first, first + count):
            _, part, whole = generated_part(seed)
            yield part, whole
        return
    shapes = [one for one in read_collection(folder) if one.truth is not None]
    complete = [one for one in shapes if one.truth is not None and (one.truth >= 0).all()]
    for part in shapes:
        if part not in complete:
            for whole in complete:
                yield part, whole


def matched(part: KnownShape, whole: KnownShape, options: MatchOptions) -> MatchedPart:
    """Match a part and compare the answer with the truth."""
    started = time.process_time()
    found = match(part.shape, whole.shape, options)
    seconds = time.process_time() - started
    assert found.dense is not None
    assert found.confidence is not None
    covered, true = _covered(found, whole), _truly_covered(part, whole)
    right = int((~covered & ~true).sum())
    return MatchedPart(
        f"{part.name} {whole.name}",
        map_error(part, whole, found.dense).direct,
        2.0 * right / max(int((~covered).sum() + (~true).sum()), 1),
        float(covered.mean()),
        float(true.mean()),
        found.confidence.probability,
        dict(found.confidence.measures),
        seconds,
    )


def _covered(found: Match, whole: KnownShape) -> BoolArray:
    assert found.dense is not None
    assert found.dense.inverse is not None
    mesh = whole.shape.mesh
    covered = np.zeros(mesh.n_vertices, dtype=np.bool_)
    covered[mesh.vertices_of(found.dense.inverse.source)] = True
    return covered


def _truly_covered(part: KnownShape, whole: KnownShape) -> BoolArray:
    assert part.truth is not None
    assert whole.truth is not None
    positions = whole.shape.surface.vertices
    partners = whole.truth[part.truth >= 0]
    apart, _ = KDTree(positions[partners]).query(positions)
    return np.asarray(apart < NEAR)


def main() -> None:
    """Match all parts and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=default_folder(), help="folder of meshes")
    parser.add_argument("--count", type=int, default=12, help="generated parts")
    parser.add_argument("--first", type=int, default=0, help="seed of the first of them")
    parser.add_argument("--detected", action="store_true", help="do not say which is the part")
    parser.add_argument("--fit", action="store_true", help="fit the confidence")
    parser.add_argument("--json", action="store_true", help="end with one line of JSON")
    arguments = parser.parse_args()
    options = MatchOptions(
        dense=True, partial="detected" if arguments.detected else "source", proof="candidates"
    )
    print(f"{'part and whole':42}{'error':>8}{'F1':>7}{'share':>7}{'true':>7}{'P':>7}{'s':>7}")
    answers = []
    for part, whole in pairs(arguments.data, arguments.count, arguments.first):
        one = matched(part, whole, options)
        answers.append(one)
        figures = one.error, one.f1, one.share, one.true_share, one.probability, one.seconds
        print(f"{one.name:42}{one.error:8.4f}" + "".join(f"{f:7.2f}" for f in figures[1:]))
    errors = np.array([one.error for one in answers])
    right = errors <= WRONG
    found = {
        "pairs": len(answers),
        "direct": float(errors.mean()),
        "median": float(np.median(errors)),
        "wrong": int((~right).sum()),
        "f1": float(np.mean([one.f1 for one in answers])),
        "seconds": float(np.mean([one.seconds for one in answers])),
    }
    print("\n" + "   ".join(f"{name} {value:.4g}" for name, value in found.items()))
    if right.any() and not right.all():
        probabilities = np.array([one.probability for one in answers])
        print_calibration("confidence", calibration(probabilities, right))
        if arguments.fit:
            measures = np.array([[one.measures[name] for name in MEASURES] for one in answers])
            print(fit_logistic(list(MEASURES), measures, right))
    if arguments.json:
        print(json.dumps(found))


if __name__ == "__main__":
    main()
