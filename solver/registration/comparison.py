"""Comparison of candidates by their refinement on few vertices, which tells them apart better."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

from solver.arrays import FloatArray
from solver.control import Control
from solver.registration.choice import Candidate, distinct, meeting
from solver.registration.confidence import margin_of
from solver.registration.fit import Fit
from solver.registration.reduction import ReducedTask
from solver.registration.refinement import refine_on_few

_OVERTAKING = 0.5
"""Difference of scores in eigenfunctions from the best candidate below which another may be better
once both are refined."""

_MOST_COMPARED = 6
"""Candidates that differ once refined, at most. A choice: as many as the last fine stage keeps."""


def may_be_overtaken(candidates: Sequence[Candidate]) -> bool:
    """Whether others than the best, which comes first, may be better once they are refined."""
    return margin_of([one.fit.score for one in candidates]) < _OVERTAKING


@dataclass(frozen=True, eq=False)
class Compared:
    """A candidate that was refined on few vertices, to be compared with others.

    Parameters
    ----------
    candidate
        As it was registered.
    fit
        Of its refinement.
    image_positions
        (V, 3) images of the few vertices of the source, at √area 1.
    """

    candidate: Candidate
    fit: Fit
    image_positions: FloatArray


def compare(few: ReducedTask, candidates: Sequence[Candidate], control: Control) -> list[Compared]:
    """Refine candidates on few vertices.

    The fit in eigenfunctions tells candidates apart less well: of generated people of unusual
    proportions, the right one may be behind fifty others by that, and the first by this.

    Parameters
    ----------
    few
        The surfaces, with few of their vertices.
    candidates
        Of the whole ones, registered halfway or finely, at least one.
    control
        May cancel; past its deadline, fewer are refined, one at least.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The source's Laplacian cannot be factored.
    """
    found = []
    for one in control.in_time(candidates, least=1):
        refined = refine_on_few(few, one, control)
        found.append(Compared(one, refined.fit, few.task.positions[refined.images]))
    return found


def best_compared(found: Sequence[Compared]) -> list[Compared]:
    """Return those that differ, the best first, of those that meet the landmarks as well as any."""
    met = meeting([one.candidate.missed for one in found])
    order = sorted(compress(found, met), key=lambda one: one.fit.score)
    return [order[row] for row in distinct((one.image_positions for one in order), _MOST_COMPARED)]
