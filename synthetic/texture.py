"""Colours of figures, functions of the rest position: the same in every pose."""

import numpy as np

from solver.arrays import FloatArray

_WAVES = np.array([[1.9, 3.1, 1.3], [-2.7, 2.3, 2.2], [2.1, -1.7, 3.4]])
"""One wave vector a channel, in 1/m: lengths of about 1.6 m, that of a figure."""
_PHASES = np.array([0.3, 1.7, 4.1])

_CLOTHS = np.array(
    [
        [[[0.80, 0.15, 0.15], [0.95, 0.55, 0.15]], [[0.90, 0.80, 0.20], [0.55, 0.75, 0.25]]],
        [[[0.15, 0.25, 0.75], [0.20, 0.60, 0.85]], [[0.45, 0.20, 0.60], [0.85, 0.45, 0.70]]],
    ]
)
"""By side (left, right), height (lower, upper) and depth (back, front)."""
_STRIPE = 0.02
"""Width in metres of stripes, darker and lighter by `_CONTRAST`."""
_CONTRAST = 0.15


def painted(rest: FloatArray, symmetric: bool = False) -> FloatArray:
    """Colours of points.

    Parameters
    ----------
    rest
        (V, 3) float64, the points in the rest pose, in metres.
    symmetric
        Whether left and right have the same colours; if not, colours differ all over the figure.

    Returns
    -------
    colors
        (V, 3) float64 in 0..1, smooth.
    """
    places = rest.copy()
    if symmetric:
        places[:, 0] = np.sqrt(places[:, 0] ** 2 + 0.02**2)  # a smooth |x|
    colors: FloatArray = 0.5 + 0.5 * np.sin(places @ _WAVES.T + _PHASES)
    return colors


def clothed(rest: FloatArray) -> FloatArray:
    """Colours of a figure dressed in eight pieces of striped cloth, dyed unevenly.

    Left and right, upper and lower, front and back are each of a colour of their own, with sharp
    seams, mixed with the smooth ones of :func:`painted`. Stripes are finer than what a coarse
    triangulation shows, as the patterns of real clothes are.

    Parameters
    ----------
    rest
        (V, 3) float64, the points in the rest pose, in metres, y up.

    Returns
    -------
    colors
        (V, 3) float64 in 0..1.
    """
    middle = 0.5 * (rest.min(axis=0) + rest.max(axis=0))
    middle[0] = 0.0
    right, upper, front = (
        (rest[:, axis] * sign > middle[axis] * sign).astype(np.int64)
        for axis, sign in ((0, -1.0), (1, 1.0), (2, 1.0))
    )
    light = np.where(rest[:, 1] // _STRIPE % 2.0 == 0.0, 1.0 - _CONTRAST, 1.0 + _CONTRAST)
    dyed = 0.5 * _CLOTHS[right, upper, front] + 0.5 * painted(rest)
    colors: FloatArray = (dyed * light[:, None]).clip(0.0, 1.0)
    return colors
