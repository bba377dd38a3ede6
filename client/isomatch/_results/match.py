"""Results of matches."""

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from pydantic import FiniteFloat

from isomatch._figures import draw_panels
from isomatch._models import (
    Alternative,
    Confidence,
    Correspondences,
    DenseCorrespondence,
    GromovHausdorff,
    Level,
    MatchParameters,
    Overlap,
    Refinement,
    SampleProof,
)
from isomatch._results.array_transfer import (
    Direction,
    TransferKind,
    by_vertex,
    goes_forwards,
    transferred,
)
from isomatch._results.geometry import Geometry
from isomatch._results.match_panels import match_panels
from isomatch._results.result_document import Drawable, Result

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


class Match(Result, Correspondences):
    """A minimum-distortion correspondence with its certificate.

    Attributes
    ----------
    version
        Version of the result format.
    source, target
        Ids of the shapes, or of the prototype and the shape.
    source_name, target_name
        Their names; None in results of earlier versions.
    source_file_vertices, target_file_vertices
        Numbers of vertices of their files; None for a prototype and in results of earlier versions.
    source_kind
        ``"shape"`` or ``"prototype"``. For a prototype, source indices are point numbers from 0.
    parameters
        Parameters of the job, with defaults filled in.
    correspondences
        Matched pairs; as arrays in :attr:`pairs` and :attr:`costs`.
    distortion
        First-order, second-order and maximal distortion.
    gromov_hausdorff
        Upper bound of the Gromov-Hausdorff distance of the matched points: half the maximal
        distortion.
    energy
        Energy of the labelling problem, equation (5); with the objective ``"linf"`` the largest
        distortion.
    lower_bound
        Lower bound of the energy of all correspondences among the candidates.
    gap
        Relative difference of `energy` and `lower_bound`.
    certified
        Whether no better correspondence exists among the candidates of the finest level. It says
        nothing of other points, and not that the answer is right.
    confidence
        Probability that the answer is right, with reasons for doubt; None where the surfaces were
        not registered: ``orientation=False``, objective ``"linf"``, or a prototype.
    alternatives
        Other good correspondences, such as reflections, each with its energy.
    levels
        Levels of the hierarchy, coarsest first.
    proof
        Least energy over all target samples of the finest level, with its own bound; None with
        ``proof="candidates"``, for a prototype, objective ``"linf"``, and too many samples.
    gromov_hausdorff_distance
        Gromov-Hausdorff distance of the samples, with its bound; None but with objective
        ``"linf"``.
    overlap
        What the shapes have in common, where one was matched as a part of the other (`partial`);
        `dense` then has only vertices that have a partner. None where both are whole.
    unmatched
        Source vertices (or points) left unmatched at their occlusion cost, or without a partner.
    refinement
        Matched points between the target's vertices; None without ``refine="gmds"``, or if a shape
        has fewer than four vertices.
    dense
        Match extended to all vertices; None without ``dense=True``, or if a shape has fewer than
        four vertices.
    misfit
        For a prototype, misfit of the target to the class, relative to examples that were left out
        (1 is typical); None for two shapes, or if it is unknown.
    warnings
        Remarks of the service on this result.
    timings
        Seconds by stage, and ``"total"``.
    """

    version: int = 1
    source: str
    source_kind: str = "shape"
    target: str
    source_name: str | None = None
    target_name: str | None = None
    source_file_vertices: int | None = None
    target_file_vertices: int | None = None
    parameters: MatchParameters
    gromov_hausdorff: FiniteFloat
    lower_bound: FiniteFloat
    gap: FiniteFloat
    certified: bool
    confidence: Confidence | None = None
    alternatives: tuple[Alternative, ...]
    levels: tuple[Level, ...]
    proof: SampleProof | None = None
    gromov_hausdorff_distance: GromovHausdorff | None = None
    overlap: Overlap | None = None
    unmatched: tuple[int, ...]
    refinement: Refinement | None = None
    dense: DenseCorrespondence | None = None
    misfit: FiniteFloat | None = None
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        proof = "certified among its candidates" if self.certified else f"gap {self.gap:.2%}"
        others = f"{len(self.alternatives)} alternatives"
        points = f"{len(self.correspondences)} points"
        sure = "" if self.confidence is None else f"{self.confidence}, "
        return f"<Match of {points}, {sure}energy {self.energy:.6g}, {proof}, {others}>"

    __str__ = __repr__

    @cached_property
    def unmatched_vertices(self) -> npt.NDArray[np.int64]:
        """Source vertices left unmatched, (m,) int64."""
        return np.array(self.unmatched, dtype=np.int64)

    def transfer(
        self,
        values: npt.ArrayLike,
        kind: TransferKind = "scalars",
        direction: Direction = "source_to_target",
        *,
        influences: int | None = None,
    ) -> npt.NDArray[Any]:
        """Carry values of one shape's vertices to those of the other, along the dense map.

        Nothing is sent: :meth:`isomatch.Client.transfer` carries files, and values of faces.

        Parameters
        ----------
        values
            Of the shape that they are carried from, row i for vertex i of its file: (V,) or
            (V, n). For ``"landmarks"``, vertex indices of any shape.
        kind
            ``"scalars"``, ``"vectors"`` and ``"colors"`` are barycentric means (components of
            vectors one by one: directions are not rotated); ``"labels"``, numbers or text, are
            those of greatest barycentric weight; ``"skinning"``, a column for each joint, are means
            divided by their sum; ``"landmarks"`` are the vertices nearest to the images.
        direction
            ``"source_to_target"`` for values of the source, ``"target_to_source"`` for those of the
            target.
        influences
            For skinning, how many joints each vertex keeps (some programs read four), those of
            greatest weight, and of equal weights the first; None for all.

        Returns
        -------
        Row i for vertex i of the other shape's file. Vertices that no face uses, or without a
        partner, have nan, -1 or an empty text; landmarks there are -1. Labels have the type of
        `values`, but unsigned, boolean and whole floating-point ones become int64, nan -1, and
        bytes text; colours of type uint8 stay such.

        Raises
        ------
        TypeError
            There are no values.
        ValueError
            The match is not dense, rows are missing or too many, a landmark is no vertex, numbers
            are infinite, labels are neither whole numbers nor text, or `influences` is less than 1.

        Examples
        --------
        >>> labels = match.transfer(source_labels, "labels")  # of the target's vertices
        """
        name, rows = self.source_name or "the source", self.source_file_vertices
        others = self.target_file_vertices
        if not goes_forwards(direction):
            name, rows, others = self.target_name or "the target", others, rows
        return transferred(self._map(), values, kind, direction, influences, name, rows, others)

    def vertex_map(self, direction: Direction = "source_to_target") -> npt.NDArray[np.int64]:
        """Return the dense map with a row for each vertex of the file, as consistent maps have it.

        Parameters
        ----------
        direction
            ``"source_to_target"`` or ``"target_to_source"``.

        Returns
        -------
        (V,) int64: row v is the vertex of the other shape's file that vertex v is mapped to; -1 if
        it has no partner, as one shape lacks it, or no face uses it.

        Raises
        ------
        ValueError
            The match is not dense.
        """
        dense = self._map()
        if goes_forwards(direction):
            along, rows = dense.source_to_target, self.source_file_vertices
        else:
            along, rows = dense.target_to_source, self.target_file_vertices
        return by_vertex(along, along.images, rows)

    def _map(self) -> DenseCorrespondence:
        if self.dense is None:
            raise ValueError("the match has no map of all vertices; match with dense=True")
        return self.dense

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
        proof = f"gap {self.gap:.2g}"
        if self.certified:
            proof = "no better correspondence among this answer's candidates"
        if chosen:
            proof = f"of the match {self.energy:.4g}, {proof}"
        elif self.confidence is not None:
            title = f"{title}\n{self.confidence}"
        return draw_panels(panels, f"{title}\nenergy {answer.energy:.4g}, {proof}")

    def _extended_hypothesis(self) -> int:
        """Hypothesis that was refined or densely extended, 0 for the match's own pairs."""
        if self.refinement is not None:
            return self.refinement.hypothesis
        return 0 if self.dense is None else self.dense.hypothesis
