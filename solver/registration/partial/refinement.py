"""Refinement of candidates beyond the eigenfunctions."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from solver.arrays import BoolArray, IntArray
from solver.control import Control
from solver.registration.choice import Candidate
from solver.registration.fit import Fit
from solver.registration.opening import torn_off
from solver.registration.partial.alignment import WEIGHTS, find_pairs, fit_to_part
from solver.registration.partial.cover import (
    covered_by_overlap,
    covered_by_part,
    covered_by_whole,
    largest_patch,
)
from solver.registration.partial.fit import mean_share, measure_refined_part
from solver.registration.partial.partiality import FINEST
from solver.registration.partial.task import PartTask
from solver.registration.reduction import Reduction
from solver.registration.refinement import FEWER_ROUNDS, LEAST_TORN_OFF
from solver.registration.rigidity import RigidDisplacement
from solver.registration.spatial import displaced_in_space
from solver.registration.surface_map import ROUNDS, Images, SurfaceMap, points_in_triangles
from solver.shape import Shape


@dataclass(frozen=True, eq=False)
class RefinedPart:
    """A candidate whose displacement was refined, with its images.

    Parameters
    ----------
    task
        The surfaces.
    candidate
        As it was registered.
    displaced
        The displaced whole.
    images, back
        Of all vertices of the whole, and of all of the part.
    strained
        Mean strain of the edges of the whole.
    """

    task: PartTask
    candidate: Candidate
    displaced: SurfaceMap
    images: IntArray
    back: Images
    strained: float

    @classmethod
    def of(
        cls,
        task: PartTask,
        candidate: Candidate,
        control: Control,
        rounds: int = ROUNDS,
    ) -> "RefinedPart":
        """Displace the whole as rigidly as possible, from where a candidate bends it.

        Parameters
        ----------
        task
            The surfaces.
        candidate
            Registered with the finest samples.
        control
            May cancel; past its deadline, less is refined.
        rounds
            Of displacement and new images.

        Raises
        ------
        Cancelled
            Through `control`.
        MeshError
            The Laplacian of the whole cannot be factored.
        """
        rest = _at_rest(task, candidate)
        known = SurfaceMap.of(*task.surfaces, candidate.alignment, reflected=False)
        images = known.images()
        covered = covered_by_part(known, images, known.nearest(), candidate.scale)
        if not task.partiality.entire:
            covered = largest_patch(task.whole, covered)
        displaced, images = known.refined(rest.drawing(covered), control, rounds)
        back, strained = displaced.inverse(), rest.strain(displaced.positions)
        return cls(task, candidate, displaced, images, back, strained)

    @property
    def scale(self) -> float:
        """√area of the whole in the part's unit."""
        return self.candidate.scale

    @cached_property
    def rest(self) -> RigidDisplacement:
        """The whole at rest, at the part's scale."""
        return _at_rest(self.task, self.candidate)

    @cached_property
    def covered(self) -> BoolArray:
        """(V,) vertices of the whole that have a partner."""
        if self.task.partiality.entire:
            return covered_by_part(self.displaced, self.images, self.back[0], self.scale)
        return covered_by_overlap(self.displaced, self.images, self.back[0], self.scale)

    @cached_property
    def part_covered(self) -> BoolArray:
        """(W,) vertices of the part that have a partner."""
        if self.task.partiality.entire:
            return np.ones(len(self.back[0]), dtype=np.bool_)
        return covered_by_whole(self.displaced, self.images, self.back, self.scale)

    @property
    def share(self) -> float:
        """Share of the whole's area that has a partner."""
        return self.displaced.source.share_of_area(self.covered)

    @property
    def part_share(self) -> float:
        """Share of the part's area that has a partner."""
        return self.displaced.target.share_of_area(self.part_covered)

    @cached_property
    def fit(self) -> Fit:
        """Its fit in distance, normals and strain."""
        share = 1.0
        if not self.task.partiality.entire:
            share = mean_share(self.share, self.part_share, self.scale)
        return measure_refined_part(
            self.displaced, self.back, self.part_covered, self.strained, share
        )

    def again(self, control: Control) -> "RefinedPart":
        """Refine it once more, drawn by what has a partner by now.

        Parameters
        ----------
        control
            May cancel; past its deadline, less is done.

        Raises
        ------
        Cancelled
            Through `control`.
        """
        return self._moved(*self.displaced.refined(self.rest.drawing(self.covered), control))

    def or_in_space(self, control: Control) -> "RefinedPart":
        """Refine the candidate from where the whole is displaced smoothly in space, too.

        Of both refinements the one is the answer that :func:`.refine_on` chooses for whole
        surfaces: by distance, normals and strain before and after.

        Parameters
        ----------
        control
            May cancel; past its deadline, nothing is done.

        Raises
        ------
        Cancelled
            Through `control`.
        """
        if control.expired:
            return self
        known = SurfaceMap.of(*self.task.surfaces, self.candidate.alignment, reflected=False)
        in_space = displaced_in_space(known, to_part=True)
        before, grown = (self._moved(one, one.images()) for one in (known, in_space))
        if grown.fit.score > before.fit.score:
            return self
        # What is smooth in space is no strain, as bones grow.
        growth = self.rest.resting_at(in_space.positions).drawing(grown.covered)
        other = self._moved(*in_space.refined(growth, control))
        gained = before.fit.score + self.fit.score - grown.fit.score - other.fit.score
        return other if gained > 0.0 else self

    def _moved(self, displaced: SurfaceMap, images: IntArray) -> "RefinedPart":
        back, strained = displaced.inverse(), self.rest.strain(displaced.positions)
        return replace(self, displaced=displaced, images=images, back=back, strained=strained)

    def mended(self, control: Control) -> "RefinedPart":
        """Refine it once more after what tears cut off the part has let go of the whole.

        As :func:`.mend` does it for whole surfaces.

        Parameters
        ----------
        control
            May cancel; past its deadline, nothing is done.

        Returns
        -------
        The same if nothing is torn off, or it fits no better for it.

        Raises
        ------
        Cancelled
            Through `control`.
        """
        whole, part = self.displaced.source, self.displaced.target.mesh
        off = torn_off(
            part, self.scale * points_in_triangles(whole.mesh.vertices, whole, *self.back[1:])
        )
        kept = self.covered & ~off[self.images]
        if off.mean() < LEAST_TORN_OFF or not kept.any() or control.expired:
            return self
        loose = self.displaced.refined(self.rest.drawing(kept), control, FEWER_ROUNDS)
        mended = self._moved(*loose).again(control)
        return min(self, mended, key=lambda one: one.fit.score)

    def on_whole(
        self, whole: Reduction, part: Reduction, shapes: tuple[Shape, Shape], control: Control
    ) -> "RefinedPart":
        """Refine the same candidate on all vertices.

        Parameters
        ----------
        whole, part
            The reduced shapes that it was refined on.
        shapes
            Those that they are reductions of.
        control
            May cancel; past its deadline, less is done.

        Raises
        ------
        Cancelled
            Through `control`.
        MeshError
            The Laplacian of the whole cannot be factored.
        """
        task, known = replace(self.task, shapes=shapes), self.candidate
        samples, points = self.task.sampled(FINEST)
        pairs = find_pairs(samples, points, known.alignment, known.scale, WEIGHTS)
        here = task.whole.at(whole.vertices[samples.vertices])
        there = task.at(part.vertices[points.vertices])
        alignment = fit_to_part(here, there, pairs, known.scale, FINEST.sizes[-1])
        candidate = replace(known, alignment=alignment)
        return RefinedPart.of(task, candidate, control)


def _at_rest(task: PartTask, candidate: Candidate) -> RigidDisplacement:
    """The whole at rest, at the scale of the part."""
    return task.whole.at_rest.resting_at(candidate.scale * task.whole.mesh.vertices)
