"""The reflection of a shape that is bilaterally symmetric but for its pose."""

from itertools import product

import numpy as np

from solver.comparison import Comparison
from solver.control import Control
from solver.dense import DenseMap, measured
from solver.functional_map import FunctionalMap, spectral_upsampling
from solver.shape import Shape

_EIGENFUNCTIONS = 6
_FINALISTS = 8
_STEP = 10


def reflection(shape: Shape, control: Control) -> DenseMap | None:
    """Find the map of a shape to itself that reverses orientation and preserves most.

    An intrinsic symmetry takes an eigenfunction of a simple eigenvalue to itself or to its negative
    (Ovsjanikov, Sun, Guibas: Global intrinsic symmetries of shapes, CGF 27(5), 2008). All signs of
    the first few are tried; those that preserve most are refined by spectral upsampling.

    Parameters
    ----------
    shape
        The shape.
    control
        May cancel.

    Returns
    -------
    ``None`` if no map was found that reverses orientation.
    """
    comparison = Comparison(shape, shape)
    embedded, k = comparison.source.embedded, comparison.source.spectrum.n_eigenpairs
    target = comparison.target.embedded
    # The first eigenfunction is constant, and the second may change sign or not.
    flips = list(product((1.0, -1.0), repeat=min(_EIGENFUNCTIONS, k - 1)))[1:]
    starts = [FunctionalMap(np.diag((1.0, *signs))) for signs in flips]
    found = []
    for start in starts:
        control.check()
        found.append(measured(comparison, start, 0))
    found.sort(key=lambda one: one.change)
    refined = []
    for one in found[:_FINALISTS]:
        control.check()
        sizes = [*range(one.functional_map.size + _STEP, k, _STEP), k, k]
        refined.append(
            measured(
                comparison,
                spectral_upsampling(one.functional_map, embedded, target, sizes),
                0,
            )
        )
    reversing = [one for one in refined if one.reverses]
    return min(reversing, key=lambda one: one.change) if reversing else None
