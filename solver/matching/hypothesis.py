"""Hypotheses of a match: solutions of the coarsest level, refined level by level (4.1)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from solver.arrays import IntArray
from solver.control import Status
from solver.labelling import UNMATCHED, LabellingProblem, Method, Solution
from solver.matching.level import Level


@dataclass(frozen=True, eq=False)
class SolvedLevel:
    """A hypothesis at one level.

    Parameters
    ----------
    problem
        Problem (5) on the level's candidates, or (6) of a prototype.
    solution
        The hypothesis' correspondence there, with its energy and bound.
    seconds
        Time spent on it.
    """

    problem: LabellingProblem
    solution: Solution[IntArray]
    seconds: float

    @property
    def least_energy(self) -> float:
        """Energy of the optimum where a search has found it, else that of the hypothesis."""
        solution = self.solution
        searched = solution.method is Method.BRANCH_AND_BOUND
        proven = searched and solution.status is Status.CONVERGED
        return solution.lower_bound if proven else solution.value


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A solution of the coarsest level, refined to the finest level so far.

    Parameters
    ----------
    levels
        From the coarsest on.
    """

    levels: tuple[SolvedLevel, ...]

    @property
    def partners(self) -> IntArray:
        """(N,) target sample of each source sample at the finest level so far."""
        return self.levels[-1].solution.answer

    @property
    def energy(self) -> float:
        """Energy at the finest level so far."""
        return self.levels[-1].solution.value

    def vertices(self, level: Level) -> tuple[IntArray, IntArray]:
        """(K,) matched source vertices and (K,) their partners on the target.

        Parameters
        ----------
        level
            The finest level so far.
        """
        matched = self.partners != UNMATCHED
        return level.source.vertices[matched], level.target.vertices[self.partners[matched]]

    def with_finest(self, finest: SolvedLevel) -> "Hypothesis":
        """Return the hypothesis with its finest level replaced."""
        return replace(self, levels=(*self.levels[:-1], finest))


def drop_duplicates(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Leave out hypotheses that have become equal to an earlier one at the finest level."""
    first: dict[bytes, Hypothesis] = {}
    for one in hypotheses:
        first.setdefault(one.partners.tobytes(), one)
    return list(first.values())


def move_to_front(hypotheses: Sequence[Hypothesis], place: int) -> list[Hypothesis]:
    """Return the hypotheses with one of them first, the others in their order."""
    return [hypotheses[place], *hypotheses[:place], *hypotheses[place + 1 :]]
