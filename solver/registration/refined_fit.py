"""Fit of a source that is displaced to a target as rigidly as possible."""

from collections.abc import Sequence

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.registration.fit import Fit
from solver.registration.surface_map import Images, SurfaceMap, points_in_triangles


def measure_refined(
    known: SurfaceMap,
    forward: Images,
    back: Images,
    here: IntArray | None = None,
    there: IntArray | None = None,
) -> Fit:
    """Measure the fit of a source that is displaced to a target as rigidly as possible.

    Parameters
    ----------
    known
        The displaced source X and the target Y.
    forward, back
        Images of vertices of X on Y, and of vertices of Y on X.
    here, there
        These vertices, by default all.

    Returns
    -------
    The fit. Means over both surfaces are geometric means of those over either. The measures are

    ``apart``
        mean distance of the vertices of either surface from the other, over √area;
    ``turned``
        root mean square distance of unit normals;
    ``strained``
        mean strain of the edges of the source.

    Raises
    ------
    MeshError
        The source's Laplacian cannot be factored.
    """
    source, target = known.source, known.target
    here, there = (
        np.arange(len(surface.normals)) if rows is None else rows
        for surface, rows in ((source, here), (target, there))
    )
    ours, theirs = known.positions, target.mesh.vertices
    apart = (
        points_in_triangles(theirs, target, *forward[1:]) - ours[here],
        points_in_triangles(ours, source, *back[1:]) - theirs[there],
    )
    turned = (
        target.normals[forward[0]] - known.normals[here],
        known.normals[back[0]] - target.normals[there],
    )
    areas = source.spectrum.mass[here], target.spectrum.mass[there]
    return Fit(
        {
            "apart": _of_both([np.linalg.norm(one, axis=1) for one in apart], areas),
            "turned": float(np.sqrt(_of_both([(one**2).sum(axis=1) for one in turned], areas))),
            "strained": known.strain,
        }
    )


def _of_both(densities: Sequence[FloatArray], areas: Sequence[FloatArray]) -> float:
    """Geometric mean of the means over both surfaces."""
    means = (np.average(one, weights=area) for one, area in zip(densities, areas, strict=True))
    return float(np.sqrt(np.prod(list(means))))
