"""As-rigid-as-possible displacement of a surface, drawn towards given places.

Sorkine and Alexa, "As-rigid-as-possible surface modeling", SGP 2007, with rotations that vary
smoothly, as in Levi and Gotsman, "Smooth rotation enhanced as-rigid-as-possible mesh animation",
IEEE TVCG 21(2), 2015: neighbourhoods are not rings of triangles, but overlap. Minimises
½ Σ_ijk w_ij a_ik ‖(z_i − z_j) − (x_i − x_j) R_k‖² + ℓ⁻² Σ_i m_i ‖z_i − p_i‖² over positions z and
rotations R_k in turn, with the weights w of the stiffness matrix S and vertex areas M = diag(m).
Neighbourhoods a = (M + h² S)⁻¹ M are those of diffusion over the width h; each row sums to 1. Waves
of the places p that are longer than ℓ are followed, shorter ones are not.
"""

import numpy as np
import scipy.sparse as sp

from solver.arrays import BoolArray, FloatArray
from solver.mesh import TriangleMesh, nearest_rotations
from solver.shape.laplacian import definite_factor


class RigidDisplacement:
    """A surface at rest, prepared for displacements.

    Parameters
    ----------
    mesh
        The surface at rest.
    operators
        Its stiffness matrix and vertex areas, of :func:`.laplacian`.
    length
        ℓ.
    width
        h; 0 for neighbourhoods of single rings.
    drawn
        (V,) vertices that are drawn to places, by default all; the others follow them.

    Raises
    ------
    MeshError
        The Laplacian cannot be factored.
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        operators: tuple[sp.csc_array, FloatArray],
        length: float,
        width: float,
        drawn: BoolArray | None = None,
    ) -> None:
        stiffness, mass = operators
        self._mass = mass[:, None]
        self._diffusion = definite_factor(sp.csc_array(sp.diags_array(mass) + width**2 * stiffness))
        self._mesh, self._rest = mesh, mesh.vertices
        self._degree = stiffness.diagonal()
        self._weights = sp.csr_array(sp.diags_array(self._degree) - stiffness)
        pull = mass / length**2
        self._pull = (pull if drawn is None else np.where(drawn, pull, 0.0))[:, None]
        self._factor = definite_factor(sp.csc_array(stiffness + sp.diags_array(self._pull[:, 0])))
        self._weighted_rest = self._weights @ self._rest

    def step(self, positions: FloatArray, places: FloatArray) -> FloatArray:
        """Rotate every vertex' neighbourhood onto its displaced one, then move all vertices.

        Parameters
        ----------
        positions
            (V, 3) displaced so far.
        places
            (V, 3) places that vertices are drawn to.

        Returns
        -------
        (V, 3) positions.
        """
        n = len(positions)
        turns = self._diffused(self._mass * self._rotations(positions).reshape(n, 9))
        own = self._degree[:, None] * self._rest - self._weighted_rest
        sums = (self._weights @ turns.reshape(n, 9)).reshape(n, 3, 3)
        edges = _product(own, turns) + _product(self._rest, sums)
        edges -= self._weights @ _product(self._rest, turns)
        return np.asarray(self._factor.solve(0.5 * edges + self._pull * places))

    def strain(self, positions: FloatArray) -> float:
        """Mean change of edges that are rotated with their ends, over their lengths.

        Parameters
        ----------
        positions
            (V, 3) displaced.
        """
        i, j = self._mesh.edges.T
        turns = self._rotations(positions)
        edges, displaced = self._rest[i] - self._rest[j], positions[i] - positions[j]
        changes = np.linalg.norm(displaced - _product(edges, 0.5 * (turns[i] + turns[j])), axis=1)
        lengths = np.linalg.norm(edges, axis=1)
        return float((changes / np.maximum(lengths, 1e-300)).mean())

    def _rotations(self, positions: FloatArray) -> FloatArray:
        """(V, 3, 3) rotations R_k: edges x_i − x_j round vertex k go to (x_i − x_j) R_k."""
        rest = self._rest
        outer = rest[:, :, None] * positions[:, None, :]
        moments = self._degree[:, None, None] * outer
        moments -= rest[:, :, None] * (self._weights @ positions)[:, None, :]
        moments -= self._weighted_rest[:, :, None] * positions[:, None, :]
        moments += (self._weights @ outer.reshape(-1, 9)).reshape(-1, 3, 3)
        return nearest_rotations(self._diffused(moments.reshape(-1, 9)))

    def _diffused(self, values: FloatArray) -> FloatArray:
        """(V, 3, 3) sums of (V, 9) values over the neighbourhoods."""
        return np.asarray(self._diffusion.solve(values)).reshape(-1, 3, 3)


def _product(rows: FloatArray, matrices: FloatArray) -> FloatArray:
    """(V, 3) each row times its matrix."""
    products: FloatArray = np.einsum("va,vab->vb", rows, matrices)
    return products
