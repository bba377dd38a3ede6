"""Distance between a registered template and its target, both ways."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray
from solver.control import Control
from solver.mesh import SurfaceTree, TriangleMesh, surface_tree

_BLOCK = 64
"""Points between two looks at the clock: one takes 5 µs, and 20 ms where each of 80,000 triangles
of a random map crosses the whole surface."""


@dataclass(frozen=True)
class SurfaceDistance:
    """Distance between two surfaces over the square root of the target's area.

    Parameters
    ----------
    mean
        The greater of two means: over the centres of the template's triangles from the target, and
        over the vertices of the target from the template.
    greatest
        The greatest of all these distances.
    """

    mean: float
    greatest: float


def surface_distance(
    positions: FloatArray,
    template: TriangleMesh,
    target: TriangleMesh,
    control: Control | None = None,
) -> SurfaceDistance:
    """Measure how far a registered template and its target are apart.

    The vertices of the template are on the target under any map, so that they tell nothing. The
    centres of its triangles are not where these cross the inside, and vertices of the target are
    far from the template where it leaves a part uncovered.

    Parameters
    ----------
    positions
        (V, 3) of :class:`.RegisteredTemplate`.
    template, target
        The meshes that were matched.
    control
        May cancel; past its deadline, fewer points are measured, spread over the arrays.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    control = control or Control()
    # Trees tell distances apart as on a surface of unit area.
    centre, size = target.vertices.mean(axis=0), np.sqrt(target.area)
    ours, theirs = (positions - centre) / size, (target.vertices - centre) / size
    centres = ours[template.faces].mean(axis=1)
    apart = (
        _distances(surface_tree(theirs, target.faces), centres, control),
        _distances(surface_tree(ours, template.faces), theirs, control),
    )
    return SurfaceDistance(
        max(float(one.mean()) for one in apart), max(float(one.max()) for one in apart)
    )


def _distances(tree: SurfaceTree, points: FloatArray, control: Control) -> FloatArray:
    """Distances of (S, 3) points from a surface, until the deadline, in no particular order."""
    count = -(-len(points) // _BLOCK)
    starts = control.in_time(range(count), least=1)
    return np.concatenate(
        [tree.distances(np.ascontiguousarray(points[start::count])) for start in starts]
    )
