"""The points of a prototype: where they are on its reference, and how far from one another."""

import io
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from isomatch._results.geometry import Geometry
from isomatch._results.plotting import saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]

_NEAR: Final = 0.05
"""How far points may be from the surface of few vertices, relative to its size."""


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
    surface
        The reference's surface, with few vertices; None where the archive does not have it.
    """

    positions: Floats
    vertex_ids: Places
    mean_distances: Floats
    spreads: Floats
    surface: Geometry | None = None

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
        shortest distances, as lines whose colour tells how much these vary within the class: the
        standard deviation over the mean. On the right the same of all pairs of points.

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
        from isomatch._results.prototype_plotting import plot_points

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
        surface=_surface(arrays, positions),
    )


def _surface(arrays: Any, positions: Floats) -> Geometry | None:
    """The first surface that is kept, if it is that of the reference: the points lie on it."""
    if "surface0_vertices" not in arrays.files:
        return None
    vertices = np.asarray(arrays["surface0_vertices"], dtype=np.float64).reshape(-1, 3)
    there = vertices[np.asarray(arrays["surface0_points"], dtype=np.int64)]
    # Surfaces are kept without the place that they have in their files.
    shift = (positions - there).mean(axis=0)
    vertices, there = vertices + shift, there + shift
    if np.abs(there - positions).max() > _NEAR * np.ptp(vertices, axis=0).max():
        return None
    faces = np.asarray(arrays["surface0_faces"], dtype=np.int64).reshape(-1, 3)
    return Geometry(vertices, faces, np.arange(len(vertices)), None)


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
