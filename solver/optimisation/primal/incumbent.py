"""Incumbent: the best correspondence known, without a bound."""

from dataclasses import dataclass

from solver.arrays import IntArray
from solver.labelling import LabellingProblem
from solver.optimisation.primal.fusion import fuse
from solver.optimisation.primal.local_search import local_search


@dataclass(frozen=True, eq=False)
class Incumbent:
    """The best correspondence known of a labelling problem.

    Parameters
    ----------
    partners
        (N,) target point of each source point, `UNMATCHED` for none.
    energy
        Its energy, (5) plus γ|X|.
    """

    partners: IntArray
    energy: float

    @classmethod
    def of(cls, problem: LabellingProblem, partners: IntArray) -> "Incumbent":
        """Return a correspondence with its energy."""
        return cls(partners, problem.energy(partners))


def improved(problem: LabellingProblem, incumbent: Incumbent, proposal: IntArray) -> Incumbent:
    """Fuse an incumbent with a proposal, and search around the result.

    Parameters
    ----------
    problem
        The labelling problem.
    incumbent
        The best correspondence known.
    proposal
        (N,) another correspondence.

    Returns
    -------
    Incumbent
        The given one unless the result has less energy.
    """
    fused = fuse(problem, incumbent.partners, local_search(problem, proposal))
    if problem.energy(fused) < incumbent.energy:
        return Incumbent.of(problem, local_search(problem, fused))
    return incumbent
