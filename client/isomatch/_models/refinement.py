"""Matched points between the vertices of the target, from generalized multidimensional scaling."""

from functools import cached_property
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field, FiniteFloat

from isomatch._models.answer import Answer


class RefinedPoint(Answer):
    """A point in a triangle of the target.

    Attributes
    ----------
    source
        0-based vertex index in the source's file.
    vertices
        0-based indices of the triangle's corners in the target's file. On a simplified shape the
        triangle is one of the simplified surface.
    weights
        Barycentric coordinates of the point.
    """

    source: int
    vertices: Annotated[tuple[int, ...], Field(min_length=3, max_length=3)]
    weights: Annotated[tuple[FiniteFloat, ...], Field(min_length=3, max_length=3)]


class Refinement(Answer):
    """Matched points refined by GMDS, equation (7) and section 7.1 of the paper.

    Attributes
    ----------
    hypothesis
        Refined solution: 0 for the match's own pairs, j for ``alternatives[j - 1]`` if its dense
        map preserves more.
    stress, initial_stress
        Weighted sum of squared differences of distances after and before, in units of the target's
        area; it never increases.
    status
        Stopping reason: ``"converged"``, ``"iterations"`` or ``"deadline"``.
    points
        One point for each pair, in their order; as arrays in :attr:`source_vertices`,
        :attr:`refined_vertices` and :attr:`refined_weights`.
    """

    hypothesis: int
    stress: FiniteFloat
    initial_stress: FiniteFloat
    status: str
    points: tuple[RefinedPoint, ...]

    @cached_property
    def source_vertices(self) -> npt.NDArray[np.int64]:
        """Vertex indices in the source's file, (n,) int64."""
        return np.array([point.source for point in self.points], dtype=np.int64)

    @cached_property
    def refined_vertices(self) -> npt.NDArray[np.int64]:
        """Corners of the points' triangles in the target's file, (n, 3) int64."""
        rows = [point.vertices for point in self.points]
        return np.array(rows, dtype=np.int64).reshape(-1, 3)

    @cached_property
    def refined_weights(self) -> npt.NDArray[np.float64]:
        """Barycentric coordinates, non-negative with sum 1, (n, 3) float64."""
        rows = [point.weights for point in self.points]
        return np.array(rows, dtype=np.float64).reshape(-1, 3)

    def refined_positions(self, vertices: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the positions of the points.

        Parameters
        ----------
        vertices
            Vertices of the target's file, (V, 3), in its order.

        Returns
        -------
        Positions, (n, 3) float64.

        Raises
        ------
        ValueError
            `vertices` is not of shape (V, 3), or has fewer vertices than the file.
        """
        places = np.asarray(vertices, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 3:
            raise ValueError(f"vertices must have shape (V, 3), not {places.shape}")
        last = int(self.refined_vertices.max(initial=-1))
        if last >= len(places):
            raise ValueError(f"there are {len(places)} vertices, but a corner is vertex {last}")
        positions: npt.NDArray[np.float64] = np.einsum(
            "nc,ncd->nd", self.refined_weights, places[self.refined_vertices]
        )
        return positions
