"""ZoomOut: refinement of a functional map by spectral upsampling.

Melzi, Ren, Rodolà, Sharma, Wonka, Ovsjanikov: ZoomOut, ACM TOG 38(6), 2019.
"""

from collections.abc import Iterable

import numpy as np

from solver.arrays import FloatArray
from solver.functional_maps.functional_map import FunctionalMap, fit_orthonormal_map


def zoomout(
    start: FunctionalMap, source: FloatArray, target: FloatArray, sizes: Iterable[int]
) -> FunctionalMap:
    """Refine a functional map with more and more eigenfunctions (Melzi et al. 2019).

    In turn, points of X are mapped to their nearest in Y under the map so far, and the orthonormal
    map of the next size is fitted to these pairs.

    Parameters
    ----------
    start
        A map between few eigenfunctions.
    source, target
        (S, K) and (M, K) values of eigenfunctions at points spread over X and Y.
    sizes
        Numbers of eigenfunctions to go through, each at most K.
    """
    current = start
    x, y = source.astype(np.float32), target.astype(np.float32)
    for size in sizes:
        partners = current.nearest(x, y)
        current = fit_orthonormal_map(source[:, :size], target[partners, :size])
    return current
