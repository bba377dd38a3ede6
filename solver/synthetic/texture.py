"""Smooth colours painted on a figure at rest, so that they are the same in every pose."""

import numpy as np

from solver.arrays import FloatArray

_WAVES = np.array([[1.9, 3.1, 1.3], [-2.7, 2.3, 2.2], [2.1, -1.7, 3.4]])
"""One wave vector a channel, in 1/m: lengths of about 1.6 m, that of a figure."""
_PHASES = np.array([0.3, 1.7, 4.1])


def painted(rest: FloatArray, symmetric: bool = False) -> FloatArray:
    """Colours of points.

    Parameters
    ----------
    rest
        (V, 3) float64, the points in the rest pose, in metres.
    symmetric
        Whether points of the left and of the right side have the same colours; if not, nothing on
        the figure has the colours of anything else nearby.

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
