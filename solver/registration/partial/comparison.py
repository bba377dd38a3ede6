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
from solver.registration.alignment import Pairs
from solver.registration.choice import Candidate, distinct
from solver.registration.fit import Fit
from solver.registration.partial.alignment import PartSamples, fit_to_part
from solver.registration.partial.fit import changes_of_curvature
from solver.registration.partial.near_distances import NearDistances
from solver.registration.partial.partiality import FINEST
from solver.registration.partial.refinement import RefinedPart
from solver.registration.partial.task import PartTask
from solver.registration.surface import Samples

_AGAIN = replace(FINEST, sizes=(20, 26, 33, 41, 50, *FINEST.sizes))
"""Stage in which refined candidates are registered again."""

_BEST = 6
"""Best candidates that are refined twice. A choice."""


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
    fit: Fit


def refine_candidates(
    task: PartTask, candidates: Iterable[Candidate], control: Control
) -> list[MeasuredPart]:
    """Refine candidates, and the best once more, by what then has a partner.

    Those of a part are registered again from where they are refined, twice before, and once after
    that; and mended before they are compared at last. Surfaces that overlap are not.

    Parameters
    ----------
    task
        The surfaces.
    candidates
        One at least.
    control
        May cancel; past its deadline, fewer are refined, one at least.

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
    comparison, kind = _Comparison.of(task), task.partiality
    found = comparison.ranked(
        comparison.refined(one, control) for one in control.in_time(candidates, least=1)
    )
    for count in kind.again:
        best = control.in_time(found[:count])
        new = (comparison.registered_again(one.part, control) for one in best)
        found = comparison.ranked(new, found)
    best = control.in_time(found[:_BEST], least=1)
    found = comparison.ranked(comparison.twice(one.part, control) for one in best)
    last = control.in_time(found[: kind.last])
    new = (comparison.registered_again(one.part, control) for one in last)
    return comparison.ranked((comparison.twice(one, control) for one in new), found)


@dataclass(frozen=True, eq=False)
class _Comparison:
    """What refined candidates are compared by.

    Parameters
    ----------
    task
        The surfaces.
    near
        Distances on the part; ``None`` where the surfaces only overlap.
    """

    task: PartTask
    near: NearDistances | None

    @classmethod
    def of(cls, task: PartTask) -> "_Comparison":
        near = None
        if task.partiality.entire:
            near = NearDistances.of(task.shapes[1], task.part.samples.vertices)
        return cls(task, near)

    def refined(self, candidate: Candidate, control: Control) -> RefinedPart:
        """Refine a candidate to be compared."""
        return RefinedPart.of(self.task, candidate, control, self.task.partiality.rounds)

    def twice(self, one: RefinedPart, control: Control) -> RefinedPart:
        """Refine a candidate once more, and mend it where that is done before the last choice."""
        again = one.again(control)
        return again.mended(control) if self.task.partiality.mended else again

    def registered_again(self, one: RefinedPart, control: Control) -> RefinedPart:
        """Register a part again from where it was refined, and refine that."""
        samples = self._samples
        here, there = (each.vertices for each in samples)
        positions = self.task.whole.mesh.vertices
        back = nearest_points(positions[one.back[0][there]], positions[here])
        pairs = Pairs.of_part(back, len(here))
        start = fit_to_part(*samples, pairs, one.scale, _AGAIN.sizes[0]), one.scale
        return self.refined(self.task.register(samples, start, _AGAIN), control)

    @cached_property
    def _samples(self) -> tuple[Samples, PartSamples]:
        """Samples at which parts are registered again."""
        return self.task.sampled(_AGAIN)

    def ranked(
        self, new: Iterable[RefinedPart], known: Iterable[MeasuredPart] = ()
    ) -> list[MeasuredPart]:
        """Measure candidates; return those that differ, of them and those known, best first."""
        order = sorted([*known, *map(self._measured, new)], key=lambda one: one.fit.score)
        positions = self.task.whole.mesh.vertices
        return [order[row] for row in distinct(positions[one.part.back[0]] for one in order)]

    def _measured(self, one: RefinedPart) -> MeasuredPart:
        task, near, back = self.task, self.near, one.back[0]
        vertices = task.part.samples.vertices[: FINEST.target_samples]
        vertices = vertices[one.part_covered[vertices]]
        values = changes_of_curvature(task.whole, task.part, vertices, back[vertices], one.scale)
        if near is not None:
            values["distorted"] = near.change(task.shapes[0], back, one.scale)
        return MeasuredPart(one, one.fit.also(values))
