"""The result of a match."""

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import FiniteFloat

from isomatch._figures import draw_panels
from isomatch._models import (
    Alternative,
    Correspondences,
    DenseCorrespondence,
    Level,
    MatchParameters,
    Refinement,
)
from isomatch._results.geometry import Geometry
from isomatch._results.match_panels import match_panels
from isomatch._results.result_document import Drawable, Result

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


class Match(Result, Correspondences):
    """A minimum-distortion correspondence, with what is proven of it.

    Attributes
    ----------
    version
        Version of the result format.
    source, target
        Ids of the shapes, or of the prototype and the shape.
    source_kind
        What the source is, ``"shape"`` or ``"prototype"``. Of a prototype, points are named by
        their numbers from 0 where vertices of a shape are.
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
        Source vertices (or points) that are cheaper to leave unmatched.
    refinement
        Where the matched points lie between the target's vertices; None if that was not asked
        for (``refine="gmds"``), or fewer than three points were matched.
    dense
        The match extended to all vertices; None likewise (``dense=True``).
    misfit
        Of a prototype, how much the target misfits its class, 1 being usual of examples that were
        left out; None of two shapes, or where nothing is known of that.
    warnings
        What the service wants known about this answer.
    timings
        Seconds by stage, and ``"total"``.
    """

    version: int = 1
    source: str
    source_kind: str = "shape"
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
    dense: DenseCorrespondence | None = None
    misfit: FiniteFloat | None = None
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        proof = "certified" if self.certified else f"gap {self.gap:.2%}"
        others = f"{len(self.alternatives)} alternatives"
        points = f"{len(self.correspondences)} points"
        return f"<Match of {points}, energy {self.energy:.6g}, {proof}, {others}>"

    __str__ = __repr__

    @cached_property
    def unmatched_vertices(self) -> npt.NDArray[np.int64]:
        """Source vertices left unmatched, shape (m,), int64."""
        return np.array(self.unmatched, dtype=np.int64)

    def drawn_ids(self) -> tuple[str, ...]:
        """Return the ids of source and target."""
        return (self.source, self.target)

    def _check_alternative(self, alternative: int) -> None:
        count = len(self.alternatives)
        if not 0 <= alternative <= count:
            there = f"it has {count}, numbered from 1" if count else "it has none"
            raise ValueError(f"the match has no alternative {alternative}: {there}")

    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        source, target = drawn
        assert isinstance(target, Geometry)
        chosen = self._extended_hypothesis() if alternative is None else alternative
        answer = (self, *self.alternatives)[chosen]
        refinement, dense = self.refinement, self.dense
        if refinement is not None and refinement.hypothesis != chosen:
            refinement = None
        if dense is not None and dense.hypothesis != chosen:
            dense = None
        panels = match_panels(answer, refinement, dense, source, target)
        title = f"{len(answer.pairs)} corresponding points"
        if alternative:
            title = f"alternative {alternative} of {len(self.alternatives)}: {title}"
        if refinement is not None:
            title += ", refined between vertices"
        if dense is not None:
            title += ", and a map of all vertices"
        proof = "proven optimal" if self.certified else f"gap {self.gap:.2g}"
        if chosen:
            proof = f"of the match {self.energy:.4g}, {proof}"
        return draw_panels(panels, f"{title}\nenergy {answer.energy:.4g}, {proof}")

    def _extended_hypothesis(self) -> int:
        """Hypothesis that was refined or densely extended, 0 for the match's own pairs."""
        if self.refinement is not None:
            return self.refinement.hypothesis
        return 0 if self.dense is None else self.dense.hypothesis
