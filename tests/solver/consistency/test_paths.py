"""Most probable paths, against all of them."""

from itertools import pairwise, permutations
from math import prod

import numpy as np
import pytest

from solver.consistency import probable_paths

Pair = tuple[int, int]


def drawn(count: int, seed: int, known: float = 1.0) -> dict[Pair, float]:
    """Probabilities of pairs, both ways the same, of which some are not known."""
    rng = np.random.default_rng(seed)
    found: dict[Pair, float] = {}
    for i in range(count):
        for j in range(i + 1, count):
            if rng.random() <= known:
                found[i, j] = found[j, i] = float(rng.random())
    return found


def all_paths(probabilities: dict[Pair, float], pair: Pair, length: int) -> dict[int, float]:
    """Greatest probability of the paths through others, by their last shape but one."""
    source, target = pair
    others = {shape for known in probabilities for shape in known} - {source, target}
    best: dict[int, float] = {}
    for count in range(1, length):
        for between in permutations(sorted(others), count):
            path = (source, *between, target)
            steps = list(pairwise(path))
            if all(step in probabilities for step in steps):
                found = prod(probabilities[step] for step in steps)
                best[between[-1]] = max(best.get(between[-1], 0.0), found)
    return best


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("length", [2, 3, 4])
@pytest.mark.parametrize("known", [1.0, 0.6])
def test_they_are_those_of_all_paths(seed: int, length: int, known: float) -> None:
    probabilities = drawn(6, seed, known)
    expected = all_paths(probabilities, (0, 1), length)
    found = probable_paths(probabilities, (0, 1), 10, length)
    assert {path[-2]: probability for probability, path in found} == pytest.approx(expected)
    for probability, path in found:
        assert (path[0], path[-1]) == (0, 1)
        assert len(set(path)) == len(path) <= length + 1
        steps = pairwise(path)
        assert probability == pytest.approx(prod(probabilities[step] for step in steps))
    ordered = [probability for probability, _ in found]
    assert ordered == sorted(ordered, reverse=True)
    assert probable_paths(probabilities, (0, 1), 2, length) == found[:2]
