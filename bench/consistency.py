"""Maps between all shapes of a class, before and after they agree: ``python -m bench.consistency``.

Mean geodesic error over √area of the pairwise maps and of those improved by one another, wrong
pairs, cycle errors, and seconds. With ``--data`` the class is a file's name up to its first digit.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from bench.collection import KnownShape, collection, pairs_of_known_truth, require
from bench.command_line import command_line, parsed, print_json
from bench.map_error import WRONG, MapError, map_error
from solver.consistency import Consistency, Pair, images_of, improve
from solver.matching import MatchOptions, match
from solver.registration import DenseCorrespondence


@dataclass(frozen=True, eq=False)
class PairwiseMap:
    """A map of two shapes, found without the others.

    Parameters
    ----------
    dense
        The map.
    probability
        That it is right.
    """

    dense: DenseCorrespondence
    probability: float


def pairwise_maps(shapes: list[KnownShape]) -> dict[Pair, PairwiseMap]:
    """Match all pairs of shapes of one class."""
    # As the service does: compositions need an image of each vertex.
    options = MatchOptions(points=32, dense=True, partial="none")
    found = {}
    for i, j in combinations(range(len(shapes)), 2):
        matched = match(shapes[i].shape, shapes[j].shape, options)
        assert matched.dense is not None
        assert matched.confidence is not None
        found[i, j] = PairwiseMap(matched.dense, matched.confidence.probability)
    return found


def made_consistent(shapes: list[KnownShape], maps: Mapping[Pair, PairwiseMap]) -> Consistency:
    """Improve pairwise maps by one another."""
    images = {}
    for (i, j), one in maps.items():
        images[i, j], images[j, i] = images_of(one.dense, shapes[i].shape, shapes[j].shape)
    probabilities = {pair: one.probability for pair, one in maps.items()}
    return improve([one.shape for one in shapes], images, probabilities)


def main() -> None:
    """Map all pairs of each class, improve them, and print a table."""
    parser = command_line(__doc__, data=True)
    arguments = parsed(parser)
    known = [one for one in collection(arguments.data) if one.truth is not None]
    require(parser, pairs_of_known_truth(known))
    figures = {}
    for category in dict.fromkeys(one.category for one in known):
        shapes = [one for one in known if one.category == category]
        if len(shapes) < 2:
            continue
        figures[category] = _measured(shapes)
        print(f"\n{category}: " + "   ".join(f"{k} {v:.4g}" for k, v in figures[category].items()))
    print_json(arguments, figures)


def _measured(shapes: list[KnownShape]) -> dict[str, float]:
    started = time.process_time()
    maps = pairwise_maps(shapes)
    pairwise = time.process_time() - started
    started = time.process_time()
    found = made_consistent(shapes, maps)
    seconds = time.process_time() - started
    before, after = [], []
    for (i, j), one in maps.items():
        better = found.improved.get((i, j))
        before.append(map_error(shapes[i], shapes[j], one.dense))
        after.append(
            before[-1] if better is None else map_error(shapes[i], shapes[j], better.dense)
        )
        _print_row(shapes, (i, j), before[-1], after[-1], found)
    direct = [np.array([one.direct for one in errors]) for errors in (before, after)]
    return {
        "pairs": len(maps),
        "direct_before": float(direct[0].mean()),
        "direct_after": float(direct[1].mean()),
        "wrong_before": int((direct[0] > WRONG).sum()),
        "wrong_after": int((direct[1] > WRONG).sum()),
        "made_wrong": int(((direct[0] <= WRONG) & (direct[1] > WRONG)).sum()),
        "changed": len(found.improved),
        "cycle_before": found.before.mean or 0.0,
        "cycle_after": found.after.mean or 0.0,
        "seconds_pairwise": pairwise,
        "seconds_consistency": seconds,
    }


def _print_row(
    shapes: list[KnownShape], pair: Pair, before: MapError, after: MapError, found: Consistency
) -> None:
    i, j = pair
    line = f"{shapes[i].name:24} {shapes[j].name:24} {before.direct:8.4f} {after.direct:8.4f}"
    cycles = (found.before.of_pair(pair), found.after.of_pair(pair))
    line += "".join(f"{one:8.3f}" for one in cycles if one is not None)
    line += f"{found.maps.probabilities[pair]:6.2f}"
    if pair in found.improved:
        better = found.improved[pair]
        through = " ".join(shapes[place].name for place in better.path[1:-1])
        line += f"  by {through}, score {better.direct_score:.2f} > {better.score:.2f}"
    print(line + ("  in doubt" if pair in found.doubtful_pairs() else ""), flush=True)


if __name__ == "__main__":
    main()
