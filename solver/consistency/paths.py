"""Most probable paths between two shapes, through others of the collection.

If the maps of pairs are right independently of one another, a composition is right with the product
of their probabilities. Paths of the greatest products are shortest paths of lengths −log p (Nguyen,
Ben-Chen, Welnicka, Ye and Guibas, "An optimization approach to improving collections of shape
maps", CGF 30(5), 2011, weigh the maps by their cycle errors instead).
"""

import heapq
from collections.abc import Mapping

from solver.consistency.maps import Pair


def probable_paths(
    probabilities: Mapping[Pair, float], pair: Pair, most: int, length: int
) -> list[tuple[float, tuple[int, ...]]]:
    """Return the most probable paths from one shape to another through others, without cycles.

    Paths that agree in all but their last step are seen as one: the most probable of those with
    each last shape but one is found, by Dijkstra's algorithm from the source.

    Parameters
    ----------
    probabilities
        Of all ordered pairs whose map is known.
    pair
        The two shapes.
    most
        Greatest number of paths.
    length
        Greatest number of maps in a path, at least 2.

    Returns
    -------
    Probability and shapes of each path, the most probable first; the direct map is none of them.
    """
    source, target = pair
    reached = _best_paths(probabilities, source, target, length - 1)
    found = [
        (probability * probabilities[last, target], (*path, target))
        for last, (probability, path) in reached.items()
        if last != source and (last, target) in probabilities
    ]
    return sorted(found, key=lambda one: (-one[0], one[1]))[:most]


def _best_paths(
    probabilities: Mapping[Pair, float], source: int, avoided: int, length: int
) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Most probable path to each shape, of at most `length` maps."""
    neighbours: dict[int, list[tuple[int, float]]] = {}
    for (here, there), probability in probabilities.items():
        if there not in (source, avoided) and here != avoided and probability > 0.0:
            neighbours.setdefault(here, []).append((there, probability))
    best: dict[int, tuple[float, tuple[int, ...]]] = {}
    fewest: dict[int, int] = {}
    queue: list[tuple[float, tuple[int, ...]]] = [(-1.0, (source,))]
    while queue:
        negative, path = heapq.heappop(queue)
        here = path[-1]
        best.setdefault(here, (-negative, path))
        # A less probable path may still reach further shapes, if it has fewer maps.
        if len(path) > length or fewest.get(here, length + 2) <= len(path):
            continue
        fewest[here] = len(path)
        for there, probability in neighbours.get(here, ()):
            if there not in path:
                heapq.heappush(queue, (negative * probability, (*path, there)))
    return best
