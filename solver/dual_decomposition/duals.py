"""The division of the costs among the subproblems: the dual variables."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.labelling import LabellingProblem, pairwise_cost


@dataclass(frozen=True, eq=False)
class Duals:
    """How the costs of (5) are divided; also a direction in which to change the division.

    The linear subproblem has what the local ones leave of the unary costs, and the target pairs
    have what the source pairs leave of the pairwise costs: the division is exact by construction,
    which is the projection of the projected subgradient.

    Parameters
    ----------
    source_unary
        (V, N) share of candidate (x, y)'s unary cost in the local subproblem {x, x'}.
    target_unary
        (V, M) its share in the local subproblem {y, y'}.
    source_pairwise
        (V, V) share of the pairwise cost of candidates a < b in their source points' subproblem;
        only the part above the diagonal is used.
    """

    source_unary: FloatArray
    target_unary: FloatArray
    source_pairwise: FloatArray

    @classmethod
    def halves(cls, problem: LabellingProblem) -> "Duals":
        """Start: pairwise costs split evenly between both sides, unary costs all linear."""
        v, (n, m) = problem.n_candidates, problem.shape
        share = np.zeros((v, v))
        _half_pairwise(
            problem.candidates,
            problem.source_distances,
            problem.target_distances,
            problem.beta,
            share,
        )
        return cls(np.zeros((v, n)), np.zeros((v, m)), share)

    @classmethod
    def zeros(cls, problem: LabellingProblem) -> "Duals":
        """Return the direction that changes nothing."""
        v, (n, m) = problem.n_candidates, problem.shape
        return cls(np.zeros((v, n)), np.zeros((v, m)), np.zeros((v, v)))

    def linear_costs(self, unary: FloatArray) -> FloatArray:
        """(V,) what is left of the unary costs for the linear subproblem."""
        left: FloatArray = unary - self.source_unary.sum(axis=1) - self.target_unary.sum(axis=1)
        return left

    def squared_norm(self) -> float:
        """Squared Euclidean norm of all the variables."""
        return float(
            np.vdot(self.source_unary, self.source_unary)
            + np.vdot(self.target_unary, self.target_unary)
            + np.vdot(self.source_pairwise, self.source_pairwise)
        )

    def scale(self, factor: float) -> None:
        """Multiply every variable by `factor`, in place."""
        for part in (self.source_unary, self.target_unary, self.source_pairwise):
            part *= factor

    def step(self, length: float, direction: "Duals") -> None:
        """Go `length` times `direction`, in place."""
        _add_scaled(self.source_unary, length, direction.source_unary)
        _add_scaled(self.target_unary, length, direction.target_unary)
        _add_scaled(self.source_pairwise, length, direction.source_pairwise)


@kernel
def _add_scaled(to: FloatArray, factor: float, what: FloatArray) -> None:
    for i in range(to.shape[0]):
        for j in range(to.shape[1]):
            to[i, j] += factor * what[i, j]


@kernel
def _half_pairwise(
    candidates: IntArray,
    source_distances: FloatArray,
    target_distances: FloatArray,
    beta: float,
    share: FloatArray,
) -> None:
    for a in range(len(candidates)):
        for b in range(a + 1, len(candidates)):
            share[a, b] = 0.5 * pairwise_cost(
                beta,
                source_distances[candidates[a, 0], candidates[b, 0]],
                target_distances[candidates[a, 1], candidates[b, 1]],
            )
