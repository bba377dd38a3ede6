"""Registration of a whole to a part of it, or of two parts: the front door of this package."""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import BoolArray
from solver.control import Control
from solver.registration.candidates import FEWEST, NO_LANDMARKS, Points
from solver.registration.confidence import Confidence
from solver.registration.dense_correspondence import DenseCorrespondence, in_numbers_of_files
from solver.registration.fit import Fit
from solver.registration.partial.comparison import MeasuredPart, refine_candidates
from solver.registration.partial.confidence import part_confidence
from solver.registration.partial.fit import score_as_wholes
from solver.registration.partial.partiality import OF_OVERLAP, OF_PART, SAME_OVERLAP, Partiality
from solver.registration.partial.search import search_part
from solver.registration.partial.task import PartTask
from solver.registration.reduction import reduced_landmarks, reduction
from solver.registration.search import STAGE
from solver.registration.surface import smooth_surface
from solver.registration.surface_map import Images
from solver.shape import Shape

_ACROSS = 0.6
"""Length over √area of a cut across the trunk: more than the girth of a thigh."""


@dataclass(frozen=True, eq=False)
class PartMap:
    """Maps of all vertices between a whole and a part of it, or between two parts that overlap.

    Parameters
    ----------
    whole, part
        The shapes.
    scale
        √area of the whole over √area of the part.
    to_part
        Images of all V vertices of the whole on the part.
    covered
        (V,) vertices of the whole that have a partner.
    share
        Their share of the whole's area.
    to_whole
        Images of all W vertices of the part on the whole.
    part_covered, part_share
        (W,) vertices of the part that have a partner, and their share of the part's area: all of
        it, unless the surfaces overlap.
    fits
        Of this registration, and of others in the same roles that differ.
    confidence
        That the registration is right.
    """

    whole: Shape
    part: Shape
    scale: float
    to_part: Images
    covered: BoolArray
    share: float
    to_whole: Images
    part_covered: BoolArray
    part_share: float
    fits: tuple[Fit, ...]
    confidence: Confidence

    @property
    def score(self) -> float:
        """Score of the fit; the less, the better."""
        return self.fits[0].score

    def among(self, other: "PartMap", control: Control) -> "PartMap":
        """Return the registration as one of two: the confidence is less if they differ.

        Parameters
        ----------
        other
            Of the same surfaces in exchanged roles; its score is not less.
        control
            Tells whether all candidates were tried.
        """
        there = self.part.mesh.vertices
        met = self.covered & other.part_covered
        away = np.linalg.norm(there[self.to_part[0][met]] - there[other.to_whole[0][met]], axis=1)
        if met.any() and away.mean() < SAME_OVERLAP * self.part.size:
            return self
        fits = self.fits[0], other.fits[0], *self.fits[1:]
        covered = min(self.share, self.part_share)
        complete = not control.expired
        confidence = part_confidence(fits, covered, OF_OVERLAP, complete=complete)
        return replace(self, fits=fits, confidence=confidence)

    def dense(self, part_is_source: bool) -> DenseCorrespondence:
        """Return the maps in the user's numbers, of the vertices that have a partner."""
        whole, part = self.whole.mesh, self.part.mesh
        to_part = in_numbers_of_files(whole, part, *self.to_part, self.covered)
        to_whole = in_numbers_of_files(part, whole, *self.to_whole, self.part_covered)
        forward, back = (to_whole, to_part) if part_is_source else (to_part, to_whole)
        return replace(forward, inverse=back)


def register_part(
    whole: Shape,
    part: Shape,
    control: Control,
    partiality: Partiality = OF_PART,
    *,
    scale: float | None = None,
    landmarks: Points = NO_LANDMARKS,
    wholly: Points = NO_LANDMARKS,
) -> PartMap | None:
    """Register a whole to a part of it: deform the whole until the part lies on it.

    The scale of the part is found, unless it is given. Two parts that overlap are registered in the
    same way: pass the one with less boundary as `whole`, since this one is deformed.

    Parameters
    ----------
    whole, part
        The shapes; the unit of length of either does not matter.
    control
        May cancel, and reports progress; past its deadline, less is tried.
    partiality
        Whether one is a part of the other, or both only overlap.
    scale
        √area of the whole over √area of the part, if it is known.
    landmarks
        Vertices of the whole and of the part that correspond.
    wholly
        Vertices that correspond by a registration of both as wholes: of surfaces that overlap, one
        candidate begins there. Unless both are cut across the trunk, so that much may be missing,
        it is the answer if no other fits clearly better.

    Returns
    -------
    PartMap
        ``None`` if a shape has too few vertices, or no labelling has enough points.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The Laplacian of the whole cannot be factored.
    """
    ours, theirs = (reduction(one, partiality.vertices) for one in (whole, part))
    fewer = ours.shape, theirs.shape
    if min(smooth_surface(one).samples.size for one in fewer) < FEWEST:
        return None
    known, begun = (reduced_landmarks(ours, theirs, one) for one in (landmarks, wholly))
    task = PartTask(fewer, partiality, scale, known)
    candidates = search_part(task, control, begun)
    if not candidates:
        return None
    control.report(STAGE, 0.6)
    refined = refine_candidates(task, candidates, control)
    if not are_cut_across(whole, part):
        refined = _as_wholes(refined, begun)
    chosen = refined[0].part
    control.report(STAGE, 0.8)
    if fewer != (whole, part):
        chosen = chosen.on_whole(ours, theirs, (whole, part), control)
        chosen = chosen.again(control).mended(control)
    elif not partiality.mended:
        chosen = chosen.mended(control)
    if partiality.in_space:
        chosen = chosen.or_in_space(control)
    fits = tuple(one.fit for one in refined)
    return PartMap(
        whole,
        part,
        chosen.scale,
        (chosen.images, *chosen.displaced.on_triangles(chosen.images)),
        chosen.covered,
        chosen.share,
        chosen.back,
        chosen.part_covered,
        chosen.part_share,
        fits,
        part_confidence(
            fits, min(chosen.share, chosen.part_share), partiality, complete=not control.expired
        ),
    )


def are_cut_across(source: Shape, target: Shape) -> bool:
    """Return whether both shapes are cut across the trunk, so that each may lack much.

    If bodies lack opposite sides, the mirror image covers more than the truth does, and fits as
    wholes.
    """
    return min(one.mesh.longest_cut for one in (source, target)) >= _ACROSS


def _as_wholes(refined: list[MeasuredPart], wholly: Points) -> list[MeasuredPart]:
    """Put the candidate that lies as both do as wholes first, unless another fits clearly better.

    Parameters
    ----------
    refined
        Candidates, the best first.
    wholly
        Vertices of the whole and of the part that correspond by a registration of wholes.
    """
    here, there = wholly
    if not len(here):
        return refined
    positions = refined[0].part.displaced.target.mesh.vertices

    def agrees(one: MeasuredPart) -> bool:
        away = np.linalg.norm(positions[one.part.images[here]] - positions[there], axis=1)
        return bool(away.mean() < SAME_OVERLAP)

    best, *others = refined
    known = next(filter(agrees, refined), best)
    if known is best or score_as_wholes(known.fit) > score_as_wholes(best.fit):
        return refined
    return [known, best, *(one for one in others if one is not known)]
