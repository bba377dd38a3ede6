"""Deviation of descriptors from their mean: the unit in which they are compared."""

import math
from typing import Final

import numpy as np

from solver.arrays import FloatArray
from solver.kernel import kernel

_CONSTANT: Final = 1e-9
"""Deviation, relative to the greatest norm, up to which descriptors are constant: what is left is
rounding noise, which would be divided by itself."""


@kernel
def descriptor_deviation(descriptors: FloatArray) -> float:
    """Root mean square deviation of descriptors from their mean.

    Parameters
    ----------
    descriptors
        (n, m) float64.

    Returns
    -------
    0 if they are constant but for rounding errors, or there are none; then they tell nothing about
    points.

    Examples
    --------
    >>> import numpy as np
    >>> descriptor_deviation(np.array([[1.0], [3.0]]))
    1.0
    >>> descriptor_deviation(np.array([[0.3], [0.1 + 0.2]]))
    0.0
    """
    n, m = descriptors.shape
    means, greatest, total = np.zeros(m), 0.0, 0.0
    for x in range(n):
        square = 0.0
        for c in range(m):
            means[c] += descriptors[x, c] / n
            square += descriptors[x, c] ** 2
        greatest = max(greatest, square)
    for x in range(n):
        for c in range(m):
            total += (descriptors[x, c] - means[c]) ** 2
    deviation = math.sqrt(total / n) if n else 0.0
    return deviation if deviation > _CONSTANT * math.sqrt(greatest) else 0.0
