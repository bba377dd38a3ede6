"""Maps of shapes with a symmetry, by the signs of eigenfunctions, and compositions with them."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from solver.control import Control
from solver.functional_maps.dense_map import DenseMap, oriented_first
from solver.functional_maps.extension import Effort, extension
from solver.functional_maps.functional_map import FunctionalMap
from solver.functional_maps.map_quality import Comparison
from solver.shape import Shape

_EIGENFUNCTIONS = 6
_FINALISTS = 4
_STEPS = 4, 6, 10
"""How fast the number of eigenfunctions grows: each leads to maps that others miss."""

_COMPOSED = 20, 30, 54
"""Eigenfunctions in which two maps are composed."""


def maps_by_signs(comparison: Comparison, control: Control, hypothesis: int = 0) -> list[DenseMap]:
    """Find maps between shapes from nothing but the order of their eigenfunctions.

    Isometric shapes have the same eigenfunctions but for signs, as long as eigenvalues are simple;
    an intrinsic symmetry is a change of signs (Ovsjanikov, Sun, Guibas: Global intrinsic symmetries
    of shapes, CGF 27(5), 2008). All signs of the first few are tried; the maps that preserve most
    are refined by spectral upsampling.

    Parameters
    ----------
    comparison
        Of the shapes.
    control
        May cancel.
    hypothesis
        What the maps shall say they come from.

    Returns
    -------
    At most twelve maps.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    x, y = comparison.source, comparison.target
    k = min(x.spectrum.n_eigenpairs, y.spectrum.n_eigenpairs)
    found = []
    # The first eigenfunction is constant.
    for signs in product((1.0, -1.0), repeat=min(_EIGENFUNCTIONS, k - 1)):
        control.check()
        start = FunctionalMap(np.diag((1.0, *signs)))
        signature, chord = comparison.differences(start.nearest(x.embedded, y.embedded))
        found.append((signature * chord, start))
    found.sort(key=lambda entry: entry[0])
    refined = []
    for _, start in found[:_FINALISTS]:
        control.check()
        refined += [extension(comparison, start, hypothesis, Effort(step=step)) for step in _STEPS]
    return refined


def reflection(shape: Shape, control: Control) -> DenseMap | None:
    """Find the map of a shape to itself that reverses orientation and preserves most.

    Parameters
    ----------
    shape
        The shape.
    control
        May cancel.

    Returns
    -------
    ``None`` if no map was found that reverses orientation.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    found = maps_by_signs(Comparison(shape, shape), control)
    # Without the identity, than which nothing preserves more.
    reversing = [one for one in found if one.reverses]
    return oriented_first(reversing, turn=-1)[0] if reversing else None


def composed(
    comparison: Comparison, first: DenseMap, then: DenseMap, control: Control, hypothesis: int = 0
) -> Iterator[DenseMap]:
    """Compose two maps, such as a reflection and one that reverses orientation, and refine that.

    A reflection that was found may be none, so what comes of it is to be looked at again.

    Parameters
    ----------
    comparison
        Of the shapes that the composition is between.
    first, then
        The maps, of which the second begins where the first ends.
    control
        May cancel; past its deadline, less is tried.
    hypothesis
        What the maps shall say they come from.

    Yields
    ------
    DenseMap
        Compositions in several numbers of eigenfunctions, refined.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    for size in _COMPOSED:
        control.check()
        if control.seconds_left() <= 0.0:
            return
        few = min(size, first.functional_map.size, then.functional_map.size)
        one, other = (each.functional_map.matrix[:few, :few] for each in (first, then))
        yield extension(comparison, FunctionalMap(other @ one), hypothesis)
