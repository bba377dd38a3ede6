"""The reference's points carried to the other examples, from each to those most similar to it.

A match of two shapes errs where they differ much. In a class, most shapes are like some other one;
so points go from the reference to the shape nearest to it, and on from whatever has them already.
"""

from collections.abc import Sequence

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.prototype.orientation import CERTAIN, oriented_images
from solver.prototype.surfaces import (
    EIGENVALUES,
    ExampleSurface,
    first_eigenvalues,
    surface_of,
)
from solver.shape import Shape

_STAGE = "matches of the examples"


def carried_points(
    shapes: Sequence[Shape], reference: int, own: IntArray, control: Control
) -> dict[int, IntArray]:
    """Carry points to the shapes that maps which keep orientation reach.

    Parameters
    ----------
    shapes
        M shapes.
    reference
        Place of the one that has the points.
    own
        (N,) its vertices.
    control
        Reports progress and cancels.

    Returns
    -------
    By place, (N,) vertices of the reference and of every shape that was reached; left is left on
    all of them.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    quiet = Control(is_cancelled=control.is_cancelled, deadline=control.deadline)
    carried = {reference: own}
    described = [first_eigenvalues(shape) for shape in shapes]
    waiting = {n for n, one in enumerate(described) if len(one) == EIGENVALUES}
    first = surface_of(shapes[reference], own)
    if first is None or reference not in waiting:
        return carried
    logarithms = {n: np.log(described[n]) for n in waiting}
    waiting -= {reference}
    surfaces: list[ExampleSurface] = [first]
    # How near the nearest one was that had the points when it was tried.
    tried: dict[int, float] = {}
    while waiting:
        control.report(_STAGE, len(carried) / len(shapes))
        nearest = {
            n: min(float(np.linalg.norm(logarithms[n] - logarithms[m])) for m in carried)
            for n in sorted(waiting)
        }
        place = min(nearest, key=lambda n: (n in tried, nearest[n]))
        if place in tried and nearest[place] >= tried[place]:
            waiting.discard(place)
            continue
        tried[place] = nearest[place]
        images = oriented_images(surfaces, shapes[place], (), quiet, least=CERTAIN)
        if images is None:
            continue
        carried[place] = images
        waiting.discard(place)
        surface = surface_of(shapes[place], images)
        if surface is not None:
            surfaces.append(surface)
    return carried
