"""Comparison of refined candidates of a part, by which the best is chosen.

In eigenfunctions wrong candidates of a part often fit better than right ones, and few of these are
near enough to the truth to be refined to it. So candidates are refined, and those that then fit
best are registered again from where that has put them, from coarse to fine: right ones come closer,
and wrong ones hardly fit better for it.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

from solver.control import Control
from solver.functional_maps import nearest_points
from solver.registration.candidates import NO_LANDMARKS
from solver.registration.choice import distinct
from solver.registration.partial.alignment import PartPairs, PartSamples, fit_to_part
from solver.registration.partial.choice import PartCandidate, PartTask, register_part_candidate
from solver.registration.partial.fit import RefinedPartFit, changes_of_curvature
from solver.registration.partial.near_distances import NearDistances
from solver.registration.partial.refinement import RefinedPart
from solver.registration.partial.search import FINEST
from solver.registration.refinement import FEWER_ROUNDS
from solver.registration.rigidity import RigidDisplacement
from solver.registration.surface import Samples, smooth_surface
from solver.registration.surface_map import ROUNDS, at_rest
from solver.shape import Shape

_AGAIN = replace(FINEST, sizes=(20, 26, 33, 41, 50, *FINEST.sizes))
"""Stage in which refined candidates are registered again."""

_ROUNDS = 8, 4
"""How many of the best are registered again in each round. Of 14 hard halves of bodies, seven were
wrong without it, and two with it, or with 12 and 6 of them."""

_BEST, _LAST = 6, 4
"""Best candidates that are refined twice, and those of a part that are registered again then."""


@dataclass(frozen=True, eq=False)
class MeasuredPart:
    """A refined candidate, as it is compared with others.

    Parameters
    ----------
    part
        The candidate.
    fit
        In all measures.
    """

    part: RefinedPart
    fit: RefinedPartFit


def refine_candidates(
    whole: Shape,
    part: Shape,
    candidates: Iterable[PartCandidate],
    control: Control,
    *,
    entire: bool,
    rescaled: bool,
) -> list[MeasuredPart]:
    """Refine candidates, and the best once more, by what then has a partner.

    Those of a part are registered again from where they are refined, twice before, and once after
    that; and mended before they are compared at last. Surfaces that overlap are not: of 59 pairs,
    13 were wrong when they were mended, else 12.

    Parameters
    ----------
    whole, part
        The shapes.
    candidates
        One at least.
    control
        May cancel; past its deadline, fewer are refined, one at least.
    entire
        As for :func:`.register_part`.
    rescaled
        Whether the scale is searched for.

    Returns
    -------
    Those that fit best first; of those that become the same only the best.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        The Laplacian of the whole cannot be factored.
    """
    comparison = _Comparison.of(whole, part, entire, rescaled)
    found = comparison.ranked(
        comparison.refined(one, control) for one in control.in_time(candidates, least=1)
    )
    if not entire:
        best = control.in_time(found[:_BEST], least=1)
        return comparison.ranked(one.part.again(control) for one in best)
    for count in _ROUNDS:
        best = control.in_time(found[:count])
        new = (comparison.registered_again(one.part, control) for one in best)
        found = comparison.ranked(new, found)
    best = control.in_time(found[:_BEST], least=1)
    found = comparison.ranked(one.part.again(control).mended(control) for one in best)
    last = control.in_time(found[:_LAST])
    new = (comparison.registered_again(one.part, control) for one in last)
    return comparison.ranked((one.again(control).mended(control) for one in new), found)


@dataclass(frozen=True, eq=False)
class _Comparison:
    """What refined candidates are compared by.

    Parameters
    ----------
    whole
        The whole.
    task
        Its surface and the part's.
    rest
        The whole at rest, of unit area.
    near
        Distances on the part; ``None`` where the surfaces only overlap.
    """

    whole: Shape
    task: PartTask
    rest: RigidDisplacement
    near: NearDistances | None

    @classmethod
    def of(cls, whole: Shape, part: Shape, entire: bool, rescaled: bool) -> "_Comparison":
        ours, theirs = smooth_surface(whole), smooth_surface(part)
        task = PartTask(ours, theirs, entire, rescaled, NO_LANDMARKS)
        near = NearDistances.of(part, theirs.samples.vertices) if entire else None
        return cls(whole, task, at_rest(ours), near)

    def refined(self, candidate: PartCandidate, control: Control) -> RefinedPart:
        """Refine a candidate to be compared: of a part, which is refined again, in few rounds."""
        surfaces, entire = (self.task.whole, self.task.part), self.task.entire
        rounds = FEWER_ROUNDS if entire else ROUNDS
        return RefinedPart.of(surfaces, candidate, self.rest, entire, control, rounds)

    def registered_again(self, one: RefinedPart, control: Control) -> RefinedPart:
        """Register a part again from where it was refined, and refine that."""
        samples = self._samples
        here, there = (each.vertices for each in samples)
        positions = self.task.whole.mesh.vertices
        back = nearest_points(positions[one.back[0][there]], positions[here])
        pairs = PartPairs.of_part(back, len(here))
        start = fit_to_part(*samples, pairs, one.scale, _AGAIN.sizes[0]), one.scale
        return self.refined(
            register_part_candidate(self.task, samples, start, _AGAIN.sizes), control
        )

    @cached_property
    def _samples(self) -> tuple[Samples, PartSamples]:
        """Samples at which parts are registered again."""
        return self.task.samples(_AGAIN)

    def ranked(
        self, new: Iterable[RefinedPart], known: Iterable[MeasuredPart] = ()
    ) -> list[MeasuredPart]:
        """Measure candidates; return those that differ, of them and those known, best first."""
        order = sorted([*known, *map(self._measured, new)], key=lambda one: one.fit.score)
        positions = self.task.whole.mesh.vertices
        return [order[row] for row in distinct(positions[one.part.back[0]] for one in order)]

    def _measured(self, one: RefinedPart) -> MeasuredPart:
        task, near, back = self.task, self.near, one.back[0]
        vertices = task.part.samples.vertices[: FINEST.part_samples]
        vertices = vertices[one.part_covered[vertices]]
        bent = changes_of_curvature(task.whole, task.part, vertices, back[vertices], one.scale)
        distorted = None if near is None else near.change(self.whole, back, one.scale)
        return MeasuredPart(one, replace(one.fit, bent=bent, distorted=distorted))
