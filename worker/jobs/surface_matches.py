"""Matches of the surfaces of a collection, each with its map or the reason why there is none."""

from typing import Final

from broker.contracts import MatchParameters
from solver import matching
from solver.control import Control
from solver.errors import MeshError, OptionError
from solver.matching import Match, MatchOptions
from solver.shape import Shape
from worker.jobs.failures import SHAPE_FAILURES, reason_of
from worker.jobs.options import options_of

TIME_UP: Final = "the job's time was up before it was matched; give fewer shapes"
"""Reason of pairs that are not matched."""

PAIR_FAILURES: Final = (*SHAPE_FAILURES, MeshError, OptionError)
"""Failures of one of several pairs, without which a job of a collection goes on."""


def match_surfaces(
    source: Shape, target: Shape, parameters: MatchParameters, control: Control
) -> Match | str:
    """Match two surfaces.

    Returns
    -------
    The match, which has a dense map, or the reason why there is none.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    if control.expired:
        return TIME_UP
    try:
        found = matching.match(source, target, options_of(MatchOptions, parameters), control)
    except PAIR_FAILURES as error:
        return reason_of(error)
    if found.dense is None:
        return TIME_UP if control.expired else "the surfaces could not be registered"
    return found
