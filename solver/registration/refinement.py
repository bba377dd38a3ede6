"""Refinement of candidates beyond the eigenfunctions, after which, in doubt, one is chosen.

Bent by eigenfunctions, wrong candidates may fit nearly as well as the right one. Displaced as
rigidly as possible, they reach the target only by larger strain, or not everywhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.registration.alignment import LOCAL, align
from solver.registration.choice import FINE, LANDMARK, Candidate, distinct
from solver.registration.fit import logarithms
from solver.registration.reduction import ReducedTask
from solver.registration.rigidity import RigidDisplacement
from solver.registration.spatial import displaced_in_space
from solver.registration.surface_map import Images, SurfaceMap, at_rest, places

_SIZES = tuple(range(20, 101, 5))
"""Eigenfunctions that a candidate is aligned by once more, in finer steps."""


_RIVAL = 0.5
_REFINED = 6
"""Difference of scores from the best candidate up to which others are refined, and how many at
most. On 150 generated pairs, no right one is farther behind."""


@dataclass(frozen=True)
class RefinedFit:
    """Measures of a source displaced to a target as rigidly as possible, each 0 for an exact copy.

    Means over both surfaces are geometric means of those over either.

    Parameters
    ----------
    apart
        Mean distance of the vertices of either surface from the other, over √area.
    turned
        Root mean square distance of unit normals.
    strained
        Mean strain of the edges of the source.
    """

    apart: float
    turned: float
    strained: float

    @property
    def measures(self) -> dict[str, float]:
        """Logarithms of the measures, by name."""
        return logarithms({"apart": self.apart, "turned": self.turned, "strained": self.strained})

    @property
    def score(self) -> float:
        """Sum of the logarithms of the measures; the less, the better."""
        return sum(self.measures.values())


@dataclass(frozen=True, eq=False)
class RefinedCandidate:
    """A candidate whose displacement was refined.

    Parameters
    ----------
    candidate
        As it was registered.
    displaced
        The map of the refined displacement.
    images
        (V,) target vertices nearest to all source vertices.
    strained
        As of :class:`RefinedFit`.
    """

    candidate: Candidate
    displaced: SurfaceMap
    images: IntArray
    strained: float

    @cached_property
    def forward(self) -> Images:
        """Images of all source vertices on the target."""
        return self.images, *self.displaced.on_triangles(self.images)

    @cached_property
    def back(self) -> Images:
        """Images of all target vertices on the source."""
        return self.displaced.inverse()

    @cached_property
    def fit(self) -> RefinedFit:
        """Its fit."""
        return RefinedFit(*_distances(self.displaced, self.forward, self.back), self.strained)


def _distances(
    known: SurfaceMap,
    forward: Images,
    back: Images,
    here: IntArray | None = None,
    there: IntArray | None = None,
) -> tuple[float, float]:
    """How far apart the displaced source and the target are, and how their normals are turned.

    Parameters
    ----------
    known
        The displaced source X and the target Y.
    forward, back
        Images of vertices of X on Y, and of vertices of Y on X.
    here, there
        These vertices, by default all.
    """
    source, target = known.source, known.target
    here, there = (
        np.arange(len(surface.normals)) if rows is None else rows
        for surface, rows in ((source, here), (target, there))
    )
    ours, theirs = known.positions, target.mesh.vertices
    apart = (
        places(theirs, target, *forward[1:]) - ours[here],
        places(ours, source, *back[1:]) - theirs[there],
    )
    turned = (
        target.normals[forward[0]] - known.normals[here],
        known.normals[back[0]] - target.normals[there],
    )
    areas = source.spectrum.mass[here], target.spectrum.mass[there]
    return (
        _of_both([np.linalg.norm(one, axis=1) for one in apart], areas),
        float(np.sqrt(_of_both([(one**2).sum(axis=1) for one in turned], areas))),
    )


def _of_both(densities: Sequence[FloatArray], areas: Sequence[FloatArray]) -> float:
    """Geometric mean of the means over both surfaces."""
    means = (np.average(one, weights=area) for one, area in zip(densities, areas, strict=True))
    return float(np.sqrt(np.prod(list(means))))


def rivals_of(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best of candidates, which comes first, and those behind it that may be better refined."""
    best = candidates[0]
    met, most = best.missed + LANDMARK, best.fit.score + _RIVAL
    return [one for one in candidates if one.missed < met and one.fit.score < most][:_REFINED]


def refine_candidate(
    reduced: ReducedTask,
    candidate: Candidate,
    control: Control,
    rigid: RigidDisplacement | None = None,
) -> RefinedCandidate:
    """Align a candidate once more, and displace the source to the target as rigidly as possible.

    Parameters
    ----------
    reduced
        The surfaces.
    candidate
        Of the whole ones, registered with the finest samples.
    control
        May cancel; past its deadline, less is refined.
    rigid
        The source at rest, if it is known.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The source's Laplacian cannot be factored.
    """
    task, pairs = reduced.task, reduced.pairs(candidate.alignment, FINE[-1])
    samples = task.sampled(FINE[-1])
    aligned = align(*samples, pairs, control.in_time(_SIZES, least=1), LOCAL)
    if aligned.size < candidate.alignment.size:
        aligned = align(*samples, pairs, _SIZES[-1:], LOCAL)
    known = SurfaceMap.of(task.source, task.target, aligned, task.is_reflected)
    rigid = rigid or at_rest(task.source, task.is_reflected)
    refined = _refined(candidate, known, rigid, control)
    if control.expired:
        return refined
    in_space = displaced_in_space(known)
    if _misfit(in_space) > _misfit(known):
        return refined
    other = _refined(candidate, in_space, rigid, control)
    return min(refined, other, key=lambda one: one.fit.score)


def _misfit(known: SurfaceMap) -> float:
    """Product of the distances of positions and of normals at the samples of both surfaces."""
    here, there = known.source.samples.vertices, known.target.samples.vertices
    images = known.images(here)
    forward = images, *known.on_triangles(images, here)
    return float(np.prod(_distances(known, forward, known.inverse(there), here, there)))


def _refined(
    candidate: Candidate, known: SurfaceMap, rigid: RigidDisplacement, control: Control
) -> RefinedCandidate:
    displaced, images = known.refined(rigid, control)
    return RefinedCandidate(candidate, displaced, images, rigid.strain(displaced.positions))


@dataclass(frozen=True, eq=False)
class RefinedChoice:
    """The best of refined candidates, and the fits of those that differ.

    Parameters
    ----------
    best
        The candidate that fits best.
    candidates, fits
        Those that differ after the refinement, and their fits, the best first.
    """

    best: RefinedCandidate
    candidates: tuple[Candidate, ...]
    fits: tuple[RefinedFit, ...]


def choose_refined(
    reduced: ReducedTask, candidates: Sequence[Candidate], control: Control
) -> RefinedChoice:
    """Refine candidates, and choose the one that fits best.

    Parameters
    ----------
    reduced, candidates
        As for :func:`refine_candidate`, one candidate at least.
    control
        May cancel; past its deadline, fewer are refined, one at least.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The source's Laplacian cannot be factored.
    """
    rigid = at_rest(reduced.task.source, reduced.task.is_reflected)
    best: RefinedCandidate | None = None
    found: list[tuple[Candidate, RefinedFit, IntArray]] = []
    for one in control.in_time(candidates, least=1):
        refined = refine_candidate(reduced, one, control, rigid)
        found.append((one, refined.fit, refined.images))
        # The maps of the others are let go: each takes some hundreds of bytes a vertex.
        if best is None or refined.fit.score < best.fit.score:
            best = refined
    assert best is not None
    found.sort(key=lambda one: one[1].score)
    rows = distinct(reduced.task.positions[images] for _, _, images in found)
    return RefinedChoice(
        best, tuple(found[row][0] for row in rows), tuple(found[row][1] for row in rows)
    )
