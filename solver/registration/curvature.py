"""Averages of the mean curvature of a surface, which hardly change where it is cut."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, mean_curvature_measures
from solver.shape.laplacian import Spectrum

CURVATURE_TIMES = 0.001, 0.003
"""Diffusion times after which mean curvatures are compared: details of 0.03 to 0.06 √area."""

_LEAST_DEVIATION = 0.02
"""Of averages, which deviate by 0.1 to 0.7 on people and animals."""

_LEAST_AREA = 0.01
"""Least share of the area round a point that triangles off the boundary must have."""


@dataclass(frozen=True, eq=False)
class AverageCurvatures:
    """Mean curvature times √t, averaged by a heat flow for m times t.

    The quotient of the curvature measure and its area, both after the flow, so that the average is
    over what is there: it hardly changes where a surface is cut, unlike the curvature of a surface
    that flows itself. It is positive where the surface is convex.

    Parameters
    ----------
    spectrum
        Of a surface of unit area.
    measures
        (K, 2) coefficients of the integrals and areas of :func:`.mean_curvature_measures`.
    spread
        (n,) vertices spread over the surface.
    """

    spectrum: Spectrum
    measures: FloatArray
    spread: IntArray

    @classmethod
    def of(cls, mesh: TriangleMesh, spectrum: Spectrum, spread: IntArray) -> "AverageCurvatures":
        """Return the averages of a surface.

        Parameters
        ----------
        mesh, spectrum
            The surface, of unit area, and its spectrum.
        spread
            (n,) vertices spread over the surface.
        """
        measures = np.stack(mean_curvature_measures(mesh), axis=1)
        return cls(spectrum, spectrum.eigenfunctions.T @ measures, spread)

    def at(self, vertices: IntArray | None = None, area: float = 1.0) -> FloatArray:
        """(S, m) averages.

        Parameters
        ----------
        vertices
            (S,) vertices, by default all.
        area
            Times are those of a surface of unit area, times this.
        """
        functions = self.spectrum.eigenfunctions
        functions = functions if vertices is None else functions[vertices]
        found = []
        for time in (area * one for one in CURVATURE_TIMES):
            decay = np.exp(-time * self.spectrum.eigenvalues)[:, None]
            integrals, areas = (functions @ (decay * self.measures)).T
            found.append(np.sqrt(time) * integrals / np.maximum(areas, _LEAST_AREA))
        return np.stack(found, axis=1)

    @cached_property
    def standardised(self) -> FloatArray:
        """(V, m) averages over their deviations."""
        return self.standardised_by(self)

    def standardised_by(
        self, whole: "AverageCurvatures", scale: float = 1.0, vertices: IntArray | None = None
    ) -> FloatArray:
        """(S, m) averages of a part, to be compared with those of the whole.

        Parameters
        ----------
        whole
            By whose deviations they are divided.
        scale
            √area of the whole in this surface's unit.
        vertices
            (S,) vertices, by default all.
        """
        found: FloatArray = self.at(vertices, scale**2) / whole._deviations
        return found

    @cached_property
    def _deviations(self) -> FloatArray:
        """(m,) mean deviations from the medians, over the vertices that are spread.

        At least `_LEAST_DEVIATION`: on a sphere they are rounding errors.
        """
        found = self.at(self.spread)
        deviations: FloatArray = np.abs(found - np.median(found, axis=0)).mean(axis=0)
        return np.maximum(deviations, _LEAST_DEVIATION)
