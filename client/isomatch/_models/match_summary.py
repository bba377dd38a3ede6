"""Matches in brief."""

from pydantic import FiniteFloat

from isomatch._models.answer import Answer
from isomatch._models.confidence import Confidence
from isomatch._models.correspondences import Distortion


class MatchSummary(Answer):
    """A match in brief; :class:`isomatch.Match` documents the fields.

    Attributes
    ----------
    confidence, distortion, energy, gap, certified, warnings
        As in the match; of services of earlier versions, `gap` is None and `warnings` empty.
    dense
        Whether it has a map of all vertices.
    """

    confidence: Confidence | None
    distortion: Distortion
    energy: FiniteFloat
    gap: FiniteFloat | None = None
    certified: bool
    dense: bool
    warnings: tuple[str, ...] = ()
