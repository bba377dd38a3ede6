"""Stages of a match: the share of each in the progress."""

from itertools import pairwise
from typing import NamedTuple

from solver.control import Control

_ENDS = 0.0, 0.4, 0.45, 0.5, 0.8, 0.83, 0.85, 1.0
"""Fractions of a match between which its stages report, each from 0 to 1."""


class Stages(NamedTuple):
    """Controls of the stages of a match, in their order."""

    sampling: Control
    enumeration: Control
    refinement: Control
    orientation: Control
    certification: Control
    proof: Control
    extension: Control

    @classmethod
    def of(cls, control: Control) -> "Stages":
        """Divide the progress of a match among its stages."""
        return cls(*(control.between(*ends) for ends in pairwise(_ENDS)))
