"""The points of a prototype: where they are on its reference, and how far from one another."""

import io
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from isomatch._plotting import saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PrototypePoints:
    """What a prototype knows of its N points, as arrays.

    Attributes
    ----------
    positions
        Where they are on the reference shape, (N, 3) float64.
    vertex_ids
        Their vertices there, 0-based indices in its file, (N,) int64.
    mean_distances
        Mean of each learned distance, (N, N) float64, in the finest level's metric; lengths on
        shapes of unit area, unless the prototype was learned with ``normalise=False``.
    spreads
        Standard deviations of the same, (N, N) float64.
    """

    positions: Floats
    vertex_ids: Places
    mean_distances: Floats
    spreads: Floats

    @classmethod
    def from_bytes(cls, archive: bytes) -> "PrototypePoints":
        """Read an archive, as :meth:`isomatch.Client.download_prototype` writes it.

        Raises
        ------
        ValueError
            It is something else.
        """
        try:
            with np.load(io.BytesIO(archive), allow_pickle=False) as arrays:
                return _read(arrays)
        except Exception as error:  # whatever a damaged archive makes its readers raise
            raise ValueError(f"this is no archive of a prototype: {error}") from error

    @property
    def bones(self) -> Places:
        """The shortest lines that join all points, (N - 1, 2) int64: a minimum spanning tree."""
        return _spanning_tree(self.mean_distances)

    def plot(self, path: str | os.PathLike[str] | None = None, title: str = "") -> "Figure":
        """Draw the points, and how much their distances vary.

        On the left the points where they are on the reference, with their numbers, joined by the
        shortest lines, whose colour tells how much that distance varies within the class: its
        standard deviation over its mean. On the right the same of all pairs of points.

        Parameters
        ----------
        path
            File to write the figure to; its ending tells the format.
        title
            Goes above.

        Raises
        ------
        MissingExtra
            matplotlib is not installed.
        OSError
            The file cannot be written.
        """
        from isomatch._prototype_plotting import plot_points

        return saved(plot_points(self, title), path)


def _read(arrays: Any) -> PrototypePoints:
    positions = np.asarray(arrays["positions"], dtype=np.float64)
    count = len(positions)
    levels = [
        int(name[9:-6])
        for name in arrays.files
        if name[:9] == "distances" and name[-6:] == "_means"
    ]
    name = f"distances{max(levels)}"
    weights, means, covariances = (
        np.asarray(arrays[f"{name}_{part}"], dtype=np.float64)
        for part in ("weights", "means", "covariances")
    )
    mean = (weights * means[:, :, 0]).sum(axis=1)
    square = (weights * (covariances[:, :, 0, 0] + means[:, :, 0] ** 2)).sum(axis=1)
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))
    return PrototypePoints(
        positions=positions.reshape(count, 3),
        vertex_ids=np.asarray(arrays["vertices"], dtype=np.int64).reshape(count),
        mean_distances=_square(mean, count),
        spreads=_square(spread, count),
    )


def _square(pairs: Floats, count: int) -> Floats:
    # The pair (i, j), i < j, is at place j(j - 1)/2 + i: the lower triangle, row by row.
    square = np.zeros((count, count))
    square[np.tril_indices(count, -1)] = pairs
    whole: Floats = square + square.T
    return whole


def _spanning_tree(distances: Floats) -> Places:
    """The tree of Prim: the nearest point outside is joined to the one inside it is nearest to."""
    count = len(distances)
    inside = np.zeros(count, dtype=np.int64)
    nearest = distances[0].copy()
    nearest[0] = np.inf
    lines = []
    for _ in range(count - 1):
        new = int(np.argmin(nearest))
        lines.append((int(inside[new]), new))
        joined = np.isinf(nearest)
        joined[new] = True
        closer = ~joined & (distances[new] < nearest)
        inside[closer] = new
        nearest = np.where(joined, np.inf, np.minimum(nearest, distances[new]))
    return np.array(lines, dtype=np.int64).reshape(-1, 2)
