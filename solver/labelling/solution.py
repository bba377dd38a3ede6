"""Solution of an optimisation problem: answer, value, lower bound, and the proof they give."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from solver.control import Status

AnswerT = TypeVar("AnswerT")

CERTIFIED_GAP = 1e-4
"""Relative gap at and below which an answer counts as proven optimal."""


class Method(StrEnum):
    """Method that found and bounded an answer."""

    BRANCH_AND_BOUND = "branch_and_bound"
    DUAL_DECOMPOSITION = "dual_decomposition"
    LOCAL_SEARCH = "local_search"
    MINIMAX = "minimax"
    GMDS = "gmds"


def relative_gap(value: float, lower_bound: float) -> float:
    """Distance of a lower bound from a value, relative to that value.

    Parameters
    ----------
    value
        Value of a solution.
    lower_bound
        A lower bound of the optimum.

    Returns
    -------
    ``(value - lower_bound) / |value|``, in [0, 1]; 0 when the two are equal.
    """
    if value <= lower_bound:
        return 0.0
    if value == 0.0:
        return 1.0
    return min((value - lower_bound) / abs(value), 1.0)


@dataclass(frozen=True, eq=False)
class Solution(Generic[AnswerT]):
    """Answer to an optimisation problem, with its certificate.

    Parameters
    ----------
    answer
        Of a labelling problem, the (N,) int64 target point of each source point, ``UNMATCHED`` for
        none; of a minimax problem, (K, 2) pairs; of GMDS, N points of a surface.
    value
        Its value: the energy (5) plus γ|X|, the greatest distortion, or the stress (7).
    lower_bound
        No solution of the problem has a smaller value; ``lower_bound <= value``.
    iterations
        Iterations, or search nodes, spent.
    method
        How it was found and bounded.
    status
        Why the method ended.
    history
        Progress of an iteration: the best lower bound after each iteration of a dual
        decomposition, the stress (7) before and after each sweep of GMDS; empty of others.
    """

    answer: AnswerT
    value: float
    lower_bound: float
    iterations: int
    method: Method
    status: Status = Status.CONVERGED
    history: tuple[float, ...] = ()

    @property
    def gap(self) -> float:
        """Relative gap, in [0, 1]."""
        return relative_gap(self.value, self.lower_bound)

    @property
    def certified(self) -> bool:
        """Whether the answer is proven optimal, to a relative `CERTIFIED_GAP`."""
        return self.gap <= CERTIFIED_GAP
