"""Refinement of candidates beyond the eigenfunctions.

Bent by eigenfunctions, wrong candidates may fit nearly as well as the right one. Displaced as
rigidly as possible, they reach the target only by larger strain, or not everywhere.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from solver.arrays import IntArray
from solver.control import Control
from solver.registration.alignment import align
from solver.registration.choice import FINE, Candidate, Stage, Task
from solver.registration.fit import Fit
from solver.registration.opening import torn_off
from solver.registration.reduction import ReducedTask
from solver.registration.refined_fit import measure_refined
from solver.registration.rigidity import RigidDisplacement
from solver.registration.spatial import displaced_in_space
from solver.registration.surface_map import ROUNDS, Images, SurfaceMap

_SIZES = tuple(range(20, 101, 5))
"""Eigenfunctions that a candidate is aligned by once more, in finer steps."""

FEWER_ROUNDS = 6
"""Rounds of refinement on few vertices, and of those in which torn pieces follow the rest."""

LEAST_TORN_OFF = 0.001
"""Share of the vertices that are torn off from which a map is mended; fewer are errors of single
images."""

_MENDED = 3
"""How often a map is mended, at most, as long as it fits better for it."""


@dataclass(frozen=True, eq=False)
class RefinedCandidate:
    """A candidate whose displacement was refined.

    Parameters
    ----------
    displaced
        The map of the refined displacement.
    images
        (V,) target vertices nearest to all source vertices.
    """

    displaced: SurfaceMap
    images: IntArray

    @cached_property
    def forward(self) -> Images:
        """Images of all source vertices on the target."""
        return self.images, *self.displaced.on_triangles(self.images)

    @cached_property
    def back(self) -> Images:
        """Images of all target vertices on the source."""
        return self.displaced.inverse()

    @cached_property
    def fit(self) -> Fit:
        """Its fit."""
        return measure_refined(self.displaced, self.forward, self.back)


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
    known = _aligned(reduced, candidate, FINE[-1], control.in_time(_SIZES, least=1))
    if known.functional_map.size < candidate.alignment.size:
        known = _aligned(reduced, candidate, FINE[-1], _SIZES[-1:])
    refined = _refined(known, control)
    if control.expired:
        return refined
    in_space = displaced_in_space(known)
    before = _score(known), _score(in_space)
    if before[1] > before[0]:
        return refined
    # What is smooth in space is no strain here, as bones grow.
    grown = in_space.rest.resting_at(in_space.positions)
    other = _refined(in_space, control, displacement=grown)
    # Refined, either lies on the target, so that what it took to get there counts as well.
    better = before[1] + other.fit.score < before[0] + refined.fit.score
    return other if better else refined


def _score(known: SurfaceMap) -> float:
    """Score of a map that is not refined, at the samples of both surfaces."""
    here, there = known.source.samples.vertices, known.target.samples.vertices
    images = known.images(here)
    forward = images, *known.on_triangles(images, here)
    return measure_refined(known, forward, known.inverse(there), here, there).score


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
    for _ in control.in_time(range(_MENDED)):
        off = torn_off(source.mesh, target.mesh.vertices[found.images])
        if off.mean() < LEAST_TORN_OFF:
            break
        loose = found.displaced.rest.drawing(~off)
        together, _ = found.displaced.refined(loose, control, FEWER_ROUNDS)
        mended = _refined(together, control, rounds)
        if mended.fit.score >= found.fit.score:
            break
        found = mended
    return found


def _refined(
    known: SurfaceMap,
    control: Control,
    rounds: int = ROUNDS,
    displacement: RigidDisplacement | None = None,
) -> RefinedCandidate:
    """Refine a map by a displacement, by default that of the source."""
    return RefinedCandidate(*known.refined(displacement or known.rest, control, rounds))


def refine_on_few(few: ReducedTask, candidate: Candidate, control: Control) -> RefinedCandidate:
    """Displace the source to the target as rigidly as possible, in few rounds, to be compared.

    Parameters
    ----------
    few
        The surfaces, with few of their vertices.
    candidate, control
        As for :func:`refine_candidate`, which raises the same.
    """
    known = _aligned(few, candidate, FINE[0], FINE[0].sizes[-1:])
    return _refined(known, control, FEWER_ROUNDS)
