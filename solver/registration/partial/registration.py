"""Registration of a whole to a part of it, or of two parts: the front door of this package."""

from dataclasses import dataclass, replace
from typing import TypeVar

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

T = TypeVar("T")

_ACROSS = 0.6
"""Length over √area of a cut across the trunk: more than the girth of a thigh."""


@dataclass(frozen=True, eq=False)
class Side:
    """One of two surfaces of which one is a part of the other, or which overlap, with its map.

    Parameters
    ----------
    shape
        With V vertices.
    unit
        √area of the surface that was bent, in this one's unit of length.
    images
        Images of all vertices on the other surface.
    covered, share
        (V,) vertices that have a partner there, and their share of the area: all of a part.
    """

    shape: Shape
    unit: float
    images: Images
    covered: BoolArray
    share: float


@dataclass(frozen=True, eq=False)
class PartMap:
    """Maps of all vertices between a whole and a part of it, or between two parts that overlap.

    Parameters
    ----------
    sides
        The source X and the target Y.
    bent
        Which of them was bent onto the other: the whole.
    fits
        Of this registration, and of others in the same roles that differ.
    confidence
        That the registration is right.
    """

    sides: tuple[Side, Side]
    bent: int
    fits: tuple[Fit, ...]
    confidence: Confidence

    @property
    def source(self) -> Side:
        """The source and its map to the target."""
        return self.sides[0]

    @property
    def target(self) -> Side:
        """The target and its map to the source."""
        return self.sides[1]

    @property
    def score(self) -> float:
        """Score of the fit; the less, the better."""
        return self.fits[0].score

    def among(self, other: "PartMap", control: Control) -> "PartMap":
        """Return the registration as one of two: the confidence is less if they differ.

        Parameters
        ----------
        other
            Of the same shapes, of which it bends the other one; its score is not less.
        control
            Tells whether all candidates were tried.
        """
        ours, theirs = (one.sides[self.bent] for one in (self, other))
        fixed = self.sides[1 - self.bent].shape
        there, met = fixed.surface.vertices, ours.covered & theirs.covered
        away = np.linalg.norm(there[ours.images[0][met]] - there[theirs.images[0][met]], axis=1)
        if met.any() and away.mean() < SAME_OVERLAP * fixed.size:
            return self
        fits = self.fits[0], other.fits[0], *self.fits[1:]
        covered = min(one.share for one in self.sides)
        complete = not control.expired
        confidence = part_confidence(fits, covered, OF_OVERLAP, complete=complete)
        return replace(self, fits=fits, confidence=confidence)

    def dense(self) -> DenseCorrespondence:
        """Return the maps in the user's numbers, of the vertices that have a partner."""
        ours, theirs = self.sides
        forward, back = (
            in_numbers_of_files(here.shape.mesh, there.shape.mesh, *here.images, here.covered)
            for here, there in ((ours, theirs), (theirs, ours))
        )
        return replace(forward, inverse=back)


def register_part(
    source: Shape,
    target: Shape,
    control: Control,
    partiality: Partiality = OF_PART,
    *,
    source_is_part: bool = False,
    scale: float | None = None,
    landmarks: Points = NO_LANDMARKS,
    wholly: Points = NO_LANDMARKS,
) -> PartMap | None:
    """Register a whole to a part of it: deform the whole until the part lies on it.

    The scale of the part is found, unless it is given. Two parts that overlap are registered in the
    same way: take the one with less boundary as the whole, since this one is deformed.

    Parameters
    ----------
    source, target
        The shapes; the unit of length of either does not matter.
    control
        May cancel, and reports progress; past its deadline, less is tried.
    partiality
        Whether one is a part of the other, or both only overlap.
    source_is_part
        Whether the source is the part, onto which the target is bent; else it is the whole.
    scale
        √area of the whole over √area of the part, if it is known.
    landmarks
        Vertices of the source and of the target that correspond.
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
    whole, part = _ordered((source, target), source_is_part)
    landmarks, wholly = (_ordered(one, source_is_part) for one in (landmarks, wholly))
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
    images = chosen.images, *chosen.displaced.on_triangles(chosen.images)
    units = whole.mesh.area**0.5, chosen.scale * part.mesh.area**0.5
    sides = (
        Side(whole, units[0], images, chosen.covered, chosen.share),
        Side(part, units[1], chosen.back, chosen.part_covered, chosen.part_share),
    )
    covered, complete = min(one.share for one in sides), not control.expired
    confidence = part_confidence(fits, covered, partiality, complete=complete)
    return PartMap(_ordered(sides, source_is_part), int(source_is_part), fits, confidence)


def _ordered(pair: tuple[T, T], exchanged: bool) -> tuple[T, T]:
    """Return source and target as whole and part, or the other way round."""
    return pair[::-1] if exchanged else pair


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
