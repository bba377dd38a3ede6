"""As-rigid-as-possible displacement of a surface, drawn towards given places.

Sorkine and Alexa, "As-rigid-as-possible surface modeling", SGP 2007, with rotations that vary
smoothly, as in Levi and Gotsman, "Smooth rotation enhanced as-rigid-as-possible mesh animation",
IEEE TVCG 21(2), 2015: neighbourhoods are not rings of triangles, but overlap. Minimises
½ Σ_ijk w_ij a_ik ‖(z_i − z_j) − (x_i − x_j) R_k‖² + ℓ⁻² Σ_i m_i ‖z_i − p_i‖² over positions z and
rotations R_k in turn, with the weights w of the stiffness matrix S and vertex areas M = diag(m).
Neighbourhoods a = (M + h² S)⁻¹ M are those of diffusion over the width h; each row sums to 1. Waves
of the places p that are longer than ℓ are followed, shorter ones are not.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU

from solver.arrays import BoolArray, FloatArray
from solver.mesh import TriangleMesh, nearest_rotations
from solver.shape.laplacian import definite_factor

Operators = tuple[sp.csc_array, FloatArray]
"""Stiffness matrix S and (V,) vertex areas, of :func:`.laplacian`."""


@dataclass(frozen=True, eq=False)
class Pull:
    """Which vertices are drawn to places, and how much.

    Parameters
    ----------
    weights
        (V, 1) ℓ⁻² m, 0 where a vertex follows the others.
    factor
        Of S + ℓ⁻² M.
    """

    weights: FloatArray
    factor: SuperLU

    @classmethod
    def of(cls, operators: Operators, length: float, drawn: BoolArray | None) -> "Pull":
        """Factor the equations of a displacement.

        Parameters
        ----------
        operators, length
            As for :class:`RigidDisplacement`.
        drawn
            (V,) which vertices are drawn; ``None`` for all.

        Raises
        ------
        MeshError
            The Laplacian cannot be factored.
        """
        stiffness, mass = operators
        pull = mass / length**2
        weights = pull if drawn is None else np.where(drawn, pull, 0.0)
        factor = definite_factor(sp.csc_array(stiffness + sp.diags_array(weights)))
        return cls(weights[:, None], factor)


@dataclass(frozen=True, eq=False)
class RigidDisplacement:
    """A surface at rest, prepared for displacements.

    Parameters
    ----------
    mesh
        The surface at rest.
    operators
        Of the surface. All but `mesh` is the same at any scale.
    length
        ℓ.
    diffusion
        Factor of M + h² S.
    pull
        On the vertices.
    """

    mesh: TriangleMesh
    operators: Operators
    length: float
    diffusion: SuperLU
    pull: Pull

    @classmethod
    def of(
        cls, mesh: TriangleMesh, operators: Operators, length: float, width: float
    ) -> "RigidDisplacement":
        """Prepare a surface of which all vertices are drawn.

        Parameters
        ----------
        mesh, operators, length
            As for the class.
        width
            h; 0 for neighbourhoods of single rings.

        Raises
        ------
        MeshError
            The Laplacian cannot be factored.
        """
        stiffness, mass = operators
        diffusion = definite_factor(sp.csc_array(sp.diags_array(mass) + width**2 * stiffness))
        return cls(mesh, operators, length, diffusion, Pull.of(operators, length, None))

    def resting_at(self, positions: FloatArray) -> "RigidDisplacement":
        """Return the surface with its (V, 3) vertices elsewhere at rest."""
        return replace(self, mesh=self.mesh.with_same_faces(vertices=positions))

    def drawing(self, drawn: BoolArray) -> "RigidDisplacement":
        """Return the surface of which only some of the (V,) vertices are drawn.

        The others follow them. All are drawn where none is chosen.

        Raises
        ------
        MeshError
            The Laplacian cannot be factored.
        """
        chosen = drawn if drawn.any() else None
        return replace(self, pull=Pull.of(self.operators, self.length, chosen))

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
        mass = self.operators[1][:, None]
        turns = self._diffused(mass * self._rotations(positions).reshape(n, 9))
        sums = (self._weights @ turns.reshape(n, 9)).reshape(n, 3, 3)
        edges = _product(self._own, turns) + _product(self._rest, sums)
        edges -= self._weights @ _product(self._rest, turns)
        return np.asarray(self.pull.factor.solve(0.5 * edges + self.pull.weights * places))

    def strain(self, positions: FloatArray) -> float:
        """Mean change of edges that are rotated with their ends, over their lengths.

        Parameters
        ----------
        positions
            (V, 3) displaced.
        """
        i, j = self.mesh.edges.T
        turns = self._rotations(positions)
        edges, displaced = self._rest[i] - self._rest[j], positions[i] - positions[j]
        changes = np.linalg.norm(displaced - _product(edges, 0.5 * (turns[i] + turns[j])), axis=1)
        lengths = np.linalg.norm(edges, axis=1)
        return float((changes / np.maximum(lengths, 1e-300)).mean())

    @property
    def _rest(self) -> FloatArray:
        return self.mesh.vertices

    @cached_property
    def _degree(self) -> FloatArray:
        return np.asarray(self.operators[0].diagonal())

    @cached_property
    def _weights(self) -> sp.csr_array:
        """(V, V) w."""
        return sp.csr_array(sp.diags_array(self._degree) - self.operators[0])

    @cached_property
    def _weighted_rest(self) -> FloatArray:
        return np.asarray(self._weights @ self._rest)

    @cached_property
    def _own(self) -> FloatArray:
        """(V, 3) Σ_j w_ij (x_i − x_j)."""
        own: FloatArray = self._degree[:, None] * self._rest - self._weighted_rest
        return own

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
        return np.asarray(self.diffusion.solve(values)).reshape(-1, 3, 3)


def _product(rows: FloatArray, matrices: FloatArray) -> FloatArray:
    """(V, 3) each row times its matrix."""
    products: FloatArray = np.einsum("va,vab->vb", rows, matrices)
    return products
