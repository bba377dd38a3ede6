"""Intrinsic symmetries: maps from the signs of eigenfunctions, reflections, and compositions."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from solver.control import Control
from solver.functional_maps.dense_map import DenseMap, rank_maps
from solver.functional_maps.extension import Effort, extend_map
from solver.functional_maps.functional_map import FunctionalMap
from solver.functional_maps.map_quality import Comparison
from solver.shape import Shape

# The constants are chosen on generated people and animals; `bench.dense` measures them.

_SIGNED_EIGENFUNCTIONS = 6
"""First eigenfunctions all of whose signs are tried."""

_REFINED_STARTS = 4
"""Best choices of signs, which are refined."""

_ZOOMOUT_STEPS = 4, 6, 10
"""Eigenfunctions added at a time: each step leads to maps that the others miss."""

_COMPOSITION_SIZES = 20, 30, 54
"""Eigenfunctions in which two maps are composed."""


def maps_from_signs(
    comparison: Comparison, control: Control, hypothesis: int = 0
) -> list[DenseMap]:
    """Find maps between shapes from the order of their eigenfunctions alone.

    Eigenfunctions of isometric shapes agree up to signs if eigenvalues are simple, and an intrinsic
    symmetry is a change of signs (Ovsjanikov, Sun, Guibas: Global intrinsic symmetries of shapes,
    CGF 27(5), 2008). All signs of the first few are tried; the maps that change the shape least
    are refined by ZoomOut.

    Parameters
    ----------
    comparison
        Of the shapes.
    control
        May cancel.
    hypothesis
        Number that the maps bear.

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
    for signs in product((1.0, -1.0), repeat=min(_SIGNED_EIGENFUNCTIONS, k - 1)):
        control.check()
        start = FunctionalMap(np.diag((1.0, *signs)))
        signature, chord = comparison.differences(start.nearest(x.embedded, y.embedded))
        found.append((signature * chord, start))
    found.sort(key=lambda entry: entry[0])
    refined = []
    for _, start in found[:_REFINED_STARTS]:
        control.check()
        refined += [
            extend_map(comparison, start, hypothesis, Effort(step=step)) for step in _ZOOMOUT_STEPS
        ]
    return refined


def find_reflection(shape: Shape, control: Control) -> DenseMap | None:
    """Find the orientation-reversing map of a shape to itself that changes it least.

    Parameters
    ----------
    shape
        The shape.
    control
        May cancel.

    Returns
    -------
    ``None`` if no map reverses orientation.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    found = maps_from_signs(Comparison(shape, shape), control)
    # The identity, which changes nothing, must not count in the comparison.
    reversing = [one for one in found if one.reverses_orientation]
    return rank_maps(reversing, reversing=True)[0] if reversing else None


def compose_maps(
    comparison: Comparison, first: DenseMap, then: DenseMap, control: Control, hypothesis: int = 0
) -> Iterator[DenseMap]:
    """Compose two maps, such as a reflection and an orientation-reversing map, and refine that.

    The compositions are measured, as a map found by :func:`find_reflection` may not be a symmetry.

    Parameters
    ----------
    comparison
        Of the source of the first map and the target of the second.
    first, then
        The maps: the target of the first is the source of the second.
    control
        May cancel; past its deadline, less is tried.
    hypothesis
        Number that the maps bear.

    Yields
    ------
    DenseMap
        Compositions in several numbers of eigenfunctions, refined.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    for size in control.in_time(_COMPOSITION_SIZES):
        few = min(size, first.functional_map.size, then.functional_map.size)
        one, other = (each.functional_map.matrix[:few, :few] for each in (first, then))
        yield extend_map(comparison, FunctionalMap(other @ one), hypothesis)
