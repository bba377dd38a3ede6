"""Where matched points lie on the target between its vertices."""

from functools import cached_property
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field, FiniteFloat

from isomatch._models.answer import Answer


class RefinedPoint(Answer):
    """A point of the target's surface, in a triangle of it.

    Attributes
    ----------
    source
        0-based vertex index in the source's file.
    vertices
        0-based indices, in the target's file, of the triangle's three corners. Of a shape that
        was simplified it is one of fewer, larger triangles, between vertices of the file.
    weights
        Barycentric coordinates: the point is the mean of the corners with these weights.
    """

    source: int
    vertices: Annotated[tuple[int, ...], Field(min_length=3, max_length=3)]
    weights: Annotated[tuple[FiniteFloat, ...], Field(min_length=3, max_length=3)]


class Refinement(Answer):
    """The matched points on the target between its vertices: GMDS, (7) and section 7.1.

    Attributes
    ----------
    hypothesis
        What was refined: 0 for the match's own pairs, j for ``alternatives[j - 1]``, if a dense
        map of that one preserves more. The points are then near its pairs.
    stress, initial_stress
        Sum of squared differences of distances, near ones weighing most, after and before; in
        units of the target's area. It never rises.
    status
        Why it ended: ``"converged"``, ``"iterations"`` or ``"deadline"``.
    points
        One for each of the match's pairs, in their order; as arrays in :attr:`source_vertices`,
        :attr:`refined_vertices` and :attr:`refined_weights`.
    """

    hypothesis: int
    stress: FiniteFloat
    initial_stress: FiniteFloat
    status: str
    points: tuple[RefinedPoint, ...]

    @cached_property
    def source_vertices(self) -> npt.NDArray[np.int64]:
        """Vertex indices in the source's file, shape (n,), int64."""
        return np.array([point.source for point in self.points], dtype=np.int64)

    @cached_property
    def refined_vertices(self) -> npt.NDArray[np.int64]:
        """Corners of the points' triangles, in the target's file, shape (n, 3), int64."""
        rows = [point.vertices for point in self.points]
        return np.array(rows, dtype=np.int64).reshape(-1, 3)

    @cached_property
    def refined_weights(self) -> npt.NDArray[np.float64]:
        """Weights of the corners, none negative, of sum 1, shape (n, 3), float64."""
        rows = [point.weights for point in self.points]
        return np.array(rows, dtype=np.float64).reshape(-1, 3)

    def refined_positions(self, vertices: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return where the points are.

        Parameters
        ----------
        vertices
            The vertices in the target's file, shape (V, 3), in its order.

        Returns
        -------
        Positions, shape (n, 3), float64.

        Raises
        ------
        ValueError
            It is not of shape (V, 3), or has fewer vertices than the file.
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
