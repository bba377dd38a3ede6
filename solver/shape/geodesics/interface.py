"""Interface of the methods of computing geodesic distances."""

from typing import Protocol

import numpy as np

from solver.arrays import FloatArray, IntArray


class Geodesics(Protocol):
    """Geodesic distances on one mesh."""

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        ...

    def distances(self, sources: IntArray) -> FloatArray:
        """Geodesic distances from some vertices to all.

        Parameters
        ----------
        sources
            (S,) int64 vertex indices.

        Returns
        -------
        (S, V) float64, in the mesh's unit of length: 0 at the source. Paths to other components
        lead over the mesh's links.

        Raises
        ------
        IndexError
            A source is not in 0..V - 1.
        """
        ...


def checked_sources(sources: IntArray, n_vertices: int) -> IntArray:
    """Return sources as int64, checked because compiled loops do not check bounds.

    Raises
    ------
    IndexError
        A source is not in 0..V - 1.
    """
    checked = np.atleast_1d(np.asarray(sources, dtype=np.int64))
    if checked.size and not (checked.min() >= 0 and checked.max() < n_vertices):
        raise IndexError(f"sources must be vertices 0..{n_vertices - 1}")
    return checked
