"""Refinement of candidates beyond the eigenfunctions, after which, in doubt, one is chosen.

Bent by eigenfunctions, wrong candidates may fit nearly as well as the right one. Displaced as
rigidly as possible, they reach the target only by larger strain, or not everywhere.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.registration.alignment import align
from solver.registration.choice import FINE, LANDMARK, Candidate, Stage, Task, distinct
from solver.registration.fit import logarithms
from solver.registration.opening import torn_off
from solver.registration.reduction import ReducedTask
from solver.registration.rigidity import RigidDisplacement
from solver.registration.spatial import displaced_in_space
from solver.registration.surface_map import ROUNDS, Images, SurfaceMap, at_rest, places

_SIZES = tuple(range(20, 101, 5))
"""Eigenfunctions that a candidate is aligned by once more, in finer steps."""

FEWER_ROUNDS = 6
"""Rounds of refinement on few vertices, and of those in which torn pieces follow the rest."""

LEAST_TORN_OFF = 0.001
"""Share of the vertices that are torn off from which a map is mended; fewer are errors of single
images."""

_MENDED = 3
"""How often a map is mended, at most, as long as it fits better for it."""

_RIVAL = 0.5
"""Difference of scores from the best candidate up to which another may be better, refined."""

_DIFFERENT = 6
"""Candidates that differ once refined, at most."""


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
    displaced
        The map of the refined displacement.
    images
        (V,) target vertices nearest to all source vertices.
    strained
        As of :class:`RefinedFit`.
    """

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


def has_rivals(candidates: Sequence[Candidate]) -> bool:
    """Whether others than the best, which comes first, may be better once they are refined."""
    best, *others = candidates
    met, most = best.missed + LANDMARK, best.fit.score + _RIVAL
    return any(one.missed < met and one.fit.score < most for one in others)


def refine_candidate(task: Task, candidate: Candidate, control: Control) -> RefinedCandidate:
    """Align a candidate once more, and displace the source to the target as rigidly as possible.

    Parameters
    ----------
    task
        The surfaces.
    candidate
        Registered with the finest samples.
    control
        May cancel; past its deadline, less is refined.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The source's Laplacian cannot be factored.
    """
    return mend(refine_on(ReducedTask.entire(task), candidate, control), control)


def refine_on(reduced: ReducedTask, candidate: Candidate, control: Control) -> RefinedCandidate:
    """Refine a candidate of whole surfaces on reduced ones.

    Parameters
    ----------
    reduced
        The surfaces with fewer of their vertices.
    candidate, control
        As for :func:`refine_candidate`, which raises the same.
    """
    task = reduced.task
    known = _aligned(reduced, candidate, FINE[-1], control.in_time(_SIZES, least=1))
    if known.functional_map.size < candidate.alignment.size:
        known = _aligned(reduced, candidate, FINE[-1], _SIZES[-1:])
    rigid = at_rest(task.source, task.is_reflected)
    refined = _refined(known, rigid, control)
    if control.expired:
        return refined
    in_space = displaced_in_space(known)
    if _misfit(in_space) > _misfit(known):
        return refined
    other = _refined(in_space, rigid, control)
    return min(refined, other, key=lambda one: one.fit.score)


def _misfit(known: SurfaceMap) -> float:
    """Product of the distances of positions and of normals at the samples of both surfaces."""
    here, there = known.source.samples.vertices, known.target.samples.vertices
    images = known.images(here)
    forward = images, *known.on_triangles(images, here)
    return float(np.prod(_distances(known, forward, known.inverse(there), here, there)))


def _aligned(
    reduced: ReducedTask, candidate: Candidate, stage: Stage, sizes: Iterable[int]
) -> SurfaceMap:
    """The map of a candidate that is aligned on the reduced surfaces, with samples of a stage."""
    task = reduced.task
    pairs = reduced.pairs(candidate.alignment, stage)
    aligned = align(*task.sampled(stage), pairs, sizes, stage.weights)
    return SurfaceMap.of(task.source, task.target, aligned, task.is_reflected)


def mend(found: RefinedCandidate, control: Control, rounds: int = ROUNDS) -> RefinedCandidate:
    """Refine once more after what a map tears off has followed the rest for some rounds.

    Eigenfunctions may put a hoof on the leg beside its own, where the displacement then holds it.
    Candidates are compared before: wrong ones are torn in many places.

    Parameters
    ----------
    found
        A refined candidate.
    control
        May cancel; past its deadline, less is mended.
    rounds
        Of displacement and new images.

    Returns
    -------
    The same if it tears nothing off, or fits no better for it.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The source's Laplacian cannot be factored.
    """
    source, target = found.displaced.source, found.displaced.target
    reflected = found.displaced.reflected
    for _ in control.in_time(range(_MENDED)):
        off = torn_off(source.mesh, target.mesh.vertices[found.images])
        if off.mean() < LEAST_TORN_OFF:
            break
        following = at_rest(source, reflected, drawn=~off)
        together, _ = found.displaced.refined(following, control, FEWER_ROUNDS)
        mended = _refined(together, at_rest(source, reflected), control, rounds)
        if mended.fit.score >= found.fit.score:
            break
        found = mended
    return found


def _refined(
    known: SurfaceMap,
    rigid: RigidDisplacement,
    control: Control,
    rounds: int = ROUNDS,
) -> RefinedCandidate:
    displaced, images = known.refined(rigid, control, rounds)
    return RefinedCandidate(displaced, images, rigid.strain(displaced.positions))


@dataclass(frozen=True, eq=False)
class Compared:
    """A candidate that was refined on few vertices, to be compared with others.

    Parameters
    ----------
    candidate
        As it was registered.
    fit
        Of its refinement.
    places
        (V, 3) images of the few vertices of the source, at √area 1.
    """

    candidate: Candidate
    fit: RefinedFit
    places: FloatArray


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
    rigid = at_rest(few.task.source, few.task.is_reflected)
    found = []
    for one in control.in_time(candidates, least=1):
        refined = refine_on_few(few, one, control, rigid)
        found.append(Compared(one, refined.fit, few.task.positions[refined.images]))
    return found


def best_compared(found: Sequence[Compared]) -> list[Compared]:
    """Return those that differ, the best first, of those that meet the landmarks as well as any."""
    met = min(one.candidate.missed for one in found) + LANDMARK
    order = sorted(
        (one for one in found if one.candidate.missed < met), key=lambda one: one.fit.score
    )
    return [order[row] for row in distinct(one.places for one in order)[:_DIFFERENT]]


def refine_on_few(
    few: ReducedTask,
    candidate: Candidate,
    control: Control,
    rigid: RigidDisplacement | None = None,
) -> RefinedCandidate:
    """Displace the source to the target as rigidly as possible, in few rounds, to be compared.

    Parameters
    ----------
    few
        The surfaces, with few of their vertices.
    candidate, control
        As for :func:`refine_candidate`, which raises the same.
    rigid
        The source at rest, if it is known.
    """
    task = few.task
    known = _aligned(few, candidate, FINE[0], FINE[0].sizes[-1:])
    rigid = rigid or at_rest(task.source, task.is_reflected)
    return _refined(known, rigid, control, FEWER_ROUNDS)
