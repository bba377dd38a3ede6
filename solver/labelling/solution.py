"""What a solver of a labelling problem returns: an answer and what is known about it."""

from dataclasses import dataclass
from enum import StrEnum

from solver.arrays import IntArray

CERTIFIED_GAP = 1e-4
"""Relative gap at and below which an answer counts as proven optimal."""


class Method(StrEnum):
    """How an answer was found and bounded."""

    BRANCH_AND_BOUND = "branch_and_bound"
    DUAL_DECOMPOSITION = "dual_decomposition"
    LOCAL_SEARCH = "local_search"
    MINIMAX = "minimax"


def relative_gap(energy: float, lower_bound: float) -> float:
    """Distance of a lower bound from an energy, relative to that energy.

    Parameters
    ----------
    energy
        Energy of a solution.
    lower_bound
        A number the optimum does not lie under.

    Returns
    -------
    ``(energy - lower_bound) / |energy|``, in [0, 1]; 0 when the two are equal.
    """
    if energy <= lower_bound:
        return 0.0
    if energy == 0.0:
        return 1.0
    return min((energy - lower_bound) / abs(energy), 1.0)


@dataclass(frozen=True, eq=False)
class Solution:
    """Answer to a labelling problem.

    Parameters
    ----------
    partners
        (N,) target point of each source point, ``UNMATCHED`` for none.
    energy
        Its energy, (5) plus γ|X|.
    lower_bound
        No solution of the problem has less energy; ``lower_bound <= energy``.
    iterations
        Iterations, or search nodes, spent.
    method
        How it was found and bounded.
    """

    partners: IntArray
    energy: float
    lower_bound: float
    iterations: int
    method: Method

    @property
    def gap(self) -> float:
        """Relative gap, in [0, 1]."""
        return relative_gap(self.energy, self.lower_bound)

    @property
    def certified(self) -> bool:
        """Whether the answer is proven optimal, to a relative `CERTIFIED_GAP`."""
        return self.gap <= CERTIFIED_GAP
