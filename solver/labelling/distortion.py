"""Section 2: distortion of the structures of two shapes by a correspondence."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray


@dataclass(frozen=True)
class Distortion:
    """Distortions of a correspondence C, in the units of the structures.

    Parameters
    ----------
    first_order
        dis₂(C), the sum of ‖f_X(x) − f_Y(y)‖² over C; ``None`` without a descriptor.
    second_order
        dis₂(C × C), the sum of (d_X(x, x') − d_Y(y, y'))² over all ordered pairs in C × C.
    linf
        dis∞(C × C), the greatest |d_X(x, x') − d_Y(y, y')|.
    """

    first_order: float | None
    second_order: float
    linf: float

    @property
    def gromov_hausdorff(self) -> float:
        """Half of `linf`: an upper bound of the Gromov-Hausdorff distance of the point sets."""
        return 0.5 * self.linf


def greatest_distortions(source_distances: FloatArray, target_distances: FloatArray) -> FloatArray:
    """Return the greatest distortion of a distance from each pair of a correspondence to another.

    Parameters
    ----------
    source_distances, target_distances
        (K, K) d_X and d_Y among the matched points, in the order of the correspondence.

    Returns
    -------
    (K,) float64; the greatest of them is dis∞(C × C).
    """
    greatest: FloatArray = np.abs(source_distances - target_distances).max(axis=1, initial=0.0)
    return greatest


def measure_distortion(
    source_distances: FloatArray,
    target_distances: FloatArray,
    source_descriptors: FloatArray | None = None,
    target_descriptors: FloatArray | None = None,
) -> Distortion:
    """Distortion of the correspondence that pairs equal rows.

    Parameters
    ----------
    source_distances, target_distances
        (K, K) d_X and d_Y among the matched points, in the order of the correspondence.
    source_descriptors, target_descriptors
        (K, m) f_X and f_Y at the matched points; both or neither.

    Returns
    -------
    Distortion
        All zero for an empty correspondence.
    """
    difference = source_distances - target_distances
    first_order = None
    if source_descriptors is not None and target_descriptors is not None:
        first_order = float(((source_descriptors - target_descriptors) ** 2).sum())
    return Distortion(
        first_order,
        second_order=float((difference**2).sum()),
        linf=float(np.abs(difference).max(initial=0.0)),
    )
