"""Points of a prototype: their positions on its reference, and their distances."""

import io
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from isomatch._figures import Floats, Indices, Panel, draw_prototype
from isomatch._results.geometry import Geometry

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_SURFACE_TOLERANCE: Final = 0.05
"""Greatest distance of points from the simplified surface, relative to its size."""


@dataclass(frozen=True, eq=False)
class PrototypePoints:
    """The N points of a prototype as arrays.

    Attributes
    ----------
    positions
        Positions on the reference shape, (N, 3) float64.
    vertex_ids
        0-based vertex indices in the reference's file, (N,) int64.
    mean_distances
        Mean of each learned distance, (N, N) float64, in the metric of the finest level; on shapes
        of unit area, unless the prototype was learned with ``normalise=False``.
    spreads
        Standard deviation of each learned distance, (N, N) float64.
    surface
        Simplified surface of the reference; None if the archive does not contain it.
    view
        Directions to the right, up and towards the viewer in figures, (3, 3): those of the
        prototype, which archives do not contain.
    """

    positions: Floats
    vertex_ids: Indices
    mean_distances: Floats
    spreads: Floats
    surface: Geometry | None = None
    view: Floats = field(default_factory=lambda: np.eye(3))

    def __repr__(self) -> str:
        return f"<PrototypePoints of {len(self.positions)} points>"

    @classmethod
    def from_bytes(cls, archive: bytes) -> "PrototypePoints":
        """Read an archive of :meth:`isomatch.Client.download_prototype`.

        Raises
        ------
        ValueError
            It is not the archive of a prototype.
        """
        try:
            with np.load(io.BytesIO(archive), allow_pickle=False) as arrays:
                return _read(arrays)
        except Exception as error:  # numpy and zipfile raise various errors for damaged archives
            raise ValueError(f"not the archive of a prototype: {error}") from error

    @property
    def spanning_tree(self) -> Indices:
        """Minimum spanning tree of the mean distances, pairs of points, (N - 1, 2) int64."""
        return _spanning_tree(self.mean_distances)

    @property
    def variations(self) -> Floats:
        """Standard deviation over mean of each distance, (N, N); NaN on the diagonal."""
        means = self.mean_distances.copy()
        np.fill_diagonal(means, np.nan)
        ratios: Floats = self.spreads / np.where(means == 0.0, np.nan, means)
        return ratios

    def panel(self, numbers: Indices) -> Panel:
        """Return some points as they are drawn, with the spanning tree and the surface.

        Parameters
        ----------
        numbers
            (n,) the points that are marked.
        """
        surface = self.surface
        return Panel(
            self.positions if surface is None else surface.vertices,
            self.positions[numbers],
            numbers,
            faces=None if surface is None else surface.faces,
            lines=self.positions[self.spanning_tree],
            caption="points of the prototype",
            view=self.view,
        )

    def plot(self, title: str = "") -> "Figure":
        """Draw the points and the variation of their distances with plotly.

        On the left, the points on the reference, joined by the minimum spanning tree of their mean
        distances, whose lines are coloured by the variation of the distance within the class:
        standard deviation over mean. On the right, the variation of all pairs of points.

        Parameters
        ----------
        title
            Text above.

        Raises
        ------
        MissingExtra
            plotly is not installed.
        """
        tree, variations = self.spanning_tree, self.variations
        panel = self.panel(np.arange(len(self.positions)))
        panel = replace(panel, line_values=variations[tree[:, 0], tree[:, 1]])
        return draw_prototype(panel, variations, title)


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
    """First surface of the archive if the points lie on it, which makes it the reference's."""
    if "surface0_vertices" not in arrays.files:
        return None
    vertices = np.asarray(arrays["surface0_vertices"], dtype=np.float64).reshape(-1, 3)
    there = vertices[np.asarray(arrays["surface0_points"], dtype=np.int64)]
    # Surfaces are stored up to a translation.
    shift = (positions - there).mean(axis=0)
    vertices, there = vertices + shift, there + shift
    if np.abs(there - positions).max() > _SURFACE_TOLERANCE * np.ptp(vertices, axis=0).max():
        return None
    faces = np.asarray(arrays["surface0_faces"], dtype=np.int64).reshape(-1, 3)
    return Geometry(vertices, faces, np.arange(len(vertices)), None)


def _square(pairs: Floats, count: int) -> Floats:
    # The pair (i, j), i < j, is at place j(j - 1)/2 + i: the lower triangle, row by row.
    square = np.zeros((count, count))
    square[np.tril_indices(count, -1)] = pairs
    whole: Floats = square + square.T
    return whole


def _spanning_tree(distances: Floats) -> Indices:
    """Prim's algorithm: join the nearest point outside the tree to its nearest point inside."""
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
