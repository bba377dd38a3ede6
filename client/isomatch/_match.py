"""The result of a match."""

import os
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pydantic import FiniteFloat, PrivateAttr

from isomatch._models import Alternative, Correspondences, Level
from isomatch._parameters import MatchParameters
from isomatch._refinement import Refinement


class Match(Correspondences):
    """A minimum-distortion correspondence, with what is proven of it.

    Attributes
    ----------
    version
        Version of the result format.
    source, target
        Ids of the shapes.
    parameters
        The parameters in force, defaults filled in.
    correspondences
        The matched pairs; :attr:`pairs` and :attr:`costs` have them as arrays.
    distortion
        First- and second-order distortion and the largest one.
    gromov_hausdorff
        Gromov-Hausdorff distance of the samples: half the largest distortion.
    energy
        Energy of the labelling problem, (5) of the paper.
    lower_bound
        No correspondence of the problem solved has a lower energy than this.
    gap
        Relative difference of `energy` and `lower_bound`.
    certified
        Whether the correspondence is proven to be the best of the problem solved.
    alternatives
        Other good correspondences, such as symmetric ones, each with its energy.
    levels
        The coarse-to-fine levels, coarsest first.
    unmatched
        Source vertices that are cheaper to leave unmatched.
    refinement
        Where the matched points lie between the target's vertices; None if that was not asked
        for (``refine="gmds"``), or fewer than three points were matched.
    warnings
        What the service wants known about this answer.
    timings
        Seconds by stage, and ``"total"``.
    """

    version: int = 1
    source: str
    target: str
    parameters: MatchParameters
    gromov_hausdorff: FiniteFloat
    lower_bound: FiniteFloat
    gap: FiniteFloat
    certified: bool
    alternatives: tuple[Alternative, ...]
    levels: tuple[Level, ...]
    unmatched: tuple[int, ...]
    refinement: Refinement | None = None
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    _document: bytes | None = PrivateAttr(default=None)

    @classmethod
    def from_json(cls, document: bytes | str) -> "Match":
        """Read a result document, as the service answers it or :meth:`save` wrote it.

        Raises
        ------
        pydantic.ValidationError
            It is not a result document.
        """
        match = cls.model_validate_json(document)
        match._document = document.encode() if isinstance(document, str) else document
        return match

    @cached_property
    def unmatched_vertices(self) -> npt.NDArray[np.int64]:
        """Source vertices left unmatched, shape (m,), int64."""
        return np.array(self.unmatched, dtype=np.int64)

    def to_json(self) -> bytes:
        """Return the result document exactly as the service sent it."""
        return self._document or self.model_dump_json().encode()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result document to a file, exactly as the service sent it.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        Path(path).write_bytes(self.to_json())
