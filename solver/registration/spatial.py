"""Displacement of a surface that is smooth in space, not along the surface.

Walls of a thin shape are near in space and far apart along it, so that eigenfunctions displace them
apart. Where a shape keeps its pose, as a bone does, what is near stays near: points x go to
x A + t + Σ_c g(x − c) w_c, with Gaussians g round centres c. Minimises the mean square of distances
between pairs plus a ridge times Σ_cd g(c − d) w_c · w_d, and goes from wide Gaussians to narrow
ones. Yuille and Grzywacz, "A mathematical analysis of the motion coherence theory", IJCV 3, 1989;
Myronenko and Song, "Point set registration: Coherent point drift", IEEE TPAMI 32(12), 2010.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from solver.arrays import FloatArray
from solver.functional_maps import mutual_nearest_points
from solver.registration.alignment import LOCAL, Pairs, embedding
from solver.registration.surface import MIRROR
from solver.registration.surface_map import SurfaceMap

_WIDTHS = tuple(float(one) for one in np.geomspace(0.2, 0.1, 12))
"""Standard deviations of the Gaussians, one for each round of displacement and new pairs."""

_CENTRES = 100
"""With 80 or 150, errors of generated skulls differ by less than a hundredth."""

_RIDGE = 1e-3
"""From 0.001 to 0.003, errors of generated skulls change by a hundredth; less is worse."""

_LEAST = 1e-9
"""Least ridge, which keeps the equations regular."""


@dataclass(frozen=True, eq=False)
class SpatialDisplacement:
    """A smooth displacement of space.

    Parameters
    ----------
    centres
        (C, 3) centres c.
    width
        Standard deviation of the Gaussians.
    affine
        (4, 3) A, and t below it.
    weights
        (C, 3) w.
    """

    centres: FloatArray
    width: float
    affine: FloatArray
    weights: FloatArray

    @classmethod
    def fit(
        cls,
        points: FloatArray,
        goals: FloatArray,
        weights: FloatArray,
        centres: FloatArray,
        width: float,
    ) -> "SpatialDisplacement":
        """Fit a displacement to pairs of points.

        Parameters
        ----------
        points, goals
            (S, 3) each.
        weights
            (S, 1) of the pairs, with sum 1.
        centres, width
            Of the displacement.
        """
        basis = np.hstack([points, np.ones((len(points), 1)), _kernel(points, centres, width)])
        weighted = (basis * weights).T
        gram = weighted @ basis + _LEAST * np.eye(basis.shape[1])
        gram[4:, 4:] += _RIDGE * _kernel(centres, centres, width)
        solution = np.asarray(np.linalg.solve(gram, weighted @ goals), dtype=np.float64)
        return cls(centres, width, solution[:4], solution[4:])

    def positions(self, points: FloatArray) -> FloatArray:
        """(N, 3) displaced points."""
        kernel = _kernel(points, self.centres, self.width)
        found: FloatArray = points @ self.affine[:3] + self.affine[3] + kernel @ self.weights
        return found

    def normals(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """(N, 3) unit normals of a displaced surface.

        Parameters
        ----------
        points, normals
            (N, 3) points of the surface and its unit normals there.
        """
        kernel = _kernel(points, self.centres, self.width) / self.width**2
        # Rows of the Jacobian are derivatives in x, y and z: those of g are g (c − x) / width².
        moments = self.centres[:, :, None] * self.weights[:, None, :]
        drawn = (kernel @ moments.reshape(-1, 9)).reshape(-1, 3, 3)
        drawn -= points[:, :, None] * (kernel @ self.weights)[:, None, :]
        jacobian = self.affine[:3] + drawn
        # Cross products of displaced tangents: the cofactors of the Jacobian.
        cofactors = np.cross(np.roll(jacobian, -1, axis=1), np.roll(jacobian, -2, axis=1))
        found = np.einsum("nd,ndj->nj", normals, cofactors)
        unit: FloatArray = found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)
        return unit


def displaced_in_space(known: SurfaceMap) -> SurfaceMap:
    """Displace the source of a map smoothly in space, from where the map displaces it.

    Parameters
    ----------
    known
        A map of the source.
    """
    here, there = known.source.samples, known.target.samples
    sides = MIRROR if known.reflected else np.ones(3)
    points, normals = here.positions * sides, known.source.normals[here.vertices] * sides
    embedded = embedding(there.positions, known.target.normals[there.vertices], LOCAL)
    displaced = known.positions[here.vertices], known.normals[here.vertices]
    for width in _WIDTHS:
        pairs = Pairs(*mutual_nearest_points(embedding(*displaced, LOCAL), embedded))
        goals = pairs.partners(there.positions, 3)
        found = SpatialDisplacement.fit(points, goals, pairs.weights, points[:_CENTRES], width)
        displaced = found.positions(points), found.normals(points, normals)
    return known.moved(found.positions(known.source.mesh.vertices * sides))


def _kernel(points: FloatArray, centres: FloatArray, width: float) -> FloatArray:
    """(N, C) Gaussians of distances."""
    found: FloatArray = np.exp(-0.5 / width**2 * cdist(points, centres, "sqeuclidean"))
    return found
