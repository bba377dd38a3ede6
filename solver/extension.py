"""A match extended to all vertices."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.dense import DenseMap, dense_map
from solver.match import DenseCorrespondence
from solver.shape import Shape

LEAST_EXTENDED = 3
"""Matched points that a map of all vertices takes at least."""

_HYPOTHESES = 4


def extended_map(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control,
) -> DenseMap | None:
    """Extend the best of a match's first few hypotheses to all vertices.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        (n,) vertices of X and (n,) vertices of Y that correspond, the answer first. Those of less
        than three points are passed over.
    control
        May cancel; past its deadline, less is tried.

    Returns
    -------
    Its `hypothesis` is a place among those given; ``None`` if the answer has too few points.
    """
    places = [i for i, (x, _) in enumerate(hypotheses) if len(x) >= LEAST_EXTENDED][:_HYPOTHESES]
    if 0 not in places:
        return None
    found = dense_map(source, target, [hypotheses[place] for place in places], control)
    return replace(found, hypothesis=places[found.hypothesis])


def dense_correspondence(found: DenseMap) -> DenseCorrespondence:
    """Name the image of every vertex of the source by the users' own numbers."""
    source, target = found.source.mesh, found.target.mesh
    ids, vertices = source.numbering
    images = found.images(np.arange(source.n_vertices, dtype=np.int64))
    return DenseCorrespondence(ids, target.vertex_ids[images[vertices]], found.hypothesis)
