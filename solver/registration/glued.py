"""Registration of surfaces whose parts are glued together where they touch.

Both surfaces are opened at their creases, and candidates are searched on what is left: limbs that
touch are farther from one another there. In doubt, slighter creases are opened, too. Each of the
best, and the answer for the surfaces as they are, says where else the surfaces are torn: they are
opened there instead, and the candidate is aligned once more, in eigenfunctions that know nothing of
the glue. The right one fits better than before, as what glue has bent is left out; wrong ones
hardly do. The best are refined, and chosen from, as those of whole surfaces are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from solver.arrays import IntArray
from solver.control import Control
from solver.errors import MeshError
from solver.registration.candidates import Points
from solver.registration.choice import COARSE, FINE, Candidate, Task, choose, distinct, mapped
from solver.registration.confidence import Confidence, margin_of, refined_confidence
from solver.registration.congruence import congruent_vertices
from solver.registration.fit import Fit
from solver.registration.opening import (
    CREASES,
    Crease,
    Opening,
    VertexMaps,
    creases,
    torn_off,
)
from solver.registration.reduction import (
    FEW_VERTICES,
    ReducedTask,
    reduced_maps,
    reduction,
    whole_maps,
)
from solver.registration.refinement import (
    FEWER_ROUNDS,
    LEAST_TORN_OFF,
    RefinedCandidate,
    mend,
    refine_candidate,
    refine_on_few,
)
from solver.registration.search import confidence_in, search
from solver.registration.surface import MIRROR, smooth_surface
from solver.registration.surface_map import Images, SurfaceMap
from solver.shape import Shape

Rematch = Callable[[Shape, Shape], Sequence[Points]]
"""Finds hypotheses, corresponding vertices, of two shapes that were opened."""

_STAGES = (COARSE[-1], *FINE)
"""Stages in which a candidate is aligned once more on surfaces that were opened where it tears
them: it is nearly right, so that of the coarse stages the last is enough."""


@dataclass(eq=False)
class OpenedCandidate:
    """A candidate on opened surfaces, which keeps its images once they are known.

    Parameters
    ----------
    openings
        Of source and target.
    candidate
        Registered on what is left of them.
    reflected
        Whether the source is reflected in space.
    """

    openings: tuple[Opening, Opening]
    candidate: Candidate
    reflected: bool = False
    _images: IntArray | None = field(default=None, init=False, repr=False)
    _refined: RefinedCandidate | None = field(default=None, init=False, repr=False)

    def images(self, vertices: IntArray, control: Control) -> IntArray:
        """(S,) vertices of the whole target that S vertices of the whole source go to.

        Where eigenfunctions alone tear pieces off, as the end of a limb that goes to another, they
        are the nearest ones next to those that the refinement on few vertices gives.
        Vertices that are left out follow those next to them.

        Parameters
        ----------
        vertices
            (S,) of the source.
        control
            May cancel; past its deadline, less is refined. Only the first call refines.

        Raises
        ------
        Cancelled
            Through `control`.
        """
        ours, theirs = self.openings
        if self._images is None:
            self._images = self._untorn(control)
        found: IntArray = theirs.vertices[self._images[ours.index_of_vertex[vertices]]]
        return found

    def vertex_maps(self) -> VertexMaps:
        """Return the maps of all vertices of the whole shapes, before any refinement."""
        ours, theirs = self.openings
        return VertexMaps(
            theirs.vertices[self._nearest[ours.index_of_vertex]],
            ours.vertices[self._map.nearest()[theirs.index_of_vertex]],
        )

    def refined(self, control: Control) -> tuple[Images, Images]:
        """Return images of all vertices of the whole source, and of the whole target, refined.

        Parameters
        ----------
        control
            May cancel; past its deadline, less is refined.

        Raises
        ------
        Cancelled
            Through `control`.
        MeshError
            The source's Laplacian cannot be factored.
        """
        ours, theirs = self.openings
        control.check()
        if (images := self._congruent) is not None:
            back = np.argsort(images)
            return (
                _of_whole((images, *theirs.shape.mesh.at_vertices(images)), ours, theirs),
                _of_whole((back, *ours.shape.mesh.at_vertices(back)), theirs, ours),
            )
        found = refine_candidate(self.task, self.candidate, control)
        return _of_whole(found.forward, ours, theirs), _of_whole(found.back, theirs, ours)

    @cached_property
    def task(self) -> Task:
        """What is left of both shapes, the source reflected if it is."""
        ours, theirs = self.openings
        direct = Task.of(ours.shape, theirs.shape)
        return direct.reflected() if self.reflected else direct

    def on_few(self, control: Control) -> RefinedCandidate:
        """Return the candidate refined on few vertices; only the first call refines.

        Raises
        ------
        Cancelled
            Through `control`.
        MeshError
            The source's Laplacian cannot be factored.
        """
        if self._refined is None:
            ours, theirs = (one.shape for one in self.openings)
            few = ReducedTask.of(ours, theirs, self.task, FEW_VERTICES)
            self._refined = refine_on_few(few, self.candidate, control)
        return self._refined

    @cached_property
    def _map(self) -> SurfaceMap:
        task = self.task
        return SurfaceMap.of(task.source, task.target, self.candidate.alignment, self.reflected)

    @cached_property
    def _nearest(self) -> IntArray:
        """(V,) vertices of what is left of the target that eigenfunctions alone map to."""
        return self._map.images()

    @cached_property
    def _congruent(self) -> IntArray | None:
        """(V,) as :meth:`_untorn`, where a rigid motion maps one surface to the other."""
        source, target = self.task.source.mesh, self.task.target.mesh
        if self.reflected:
            source = source.with_same_faces(vertices=source.vertices * MIRROR)
        return congruent_vertices(source, target, self._nearest)

    def _untorn(self, control: Control) -> IntArray:
        """(V,) vertices of what is left of the target that those of the source go to."""
        if self._congruent is not None:
            return self._congruent
        images, task = self._nearest, self.task
        off = torn_off(task.source.mesh, task.positions[images])
        if off.mean() < LEAST_TORN_OFF:
            return images
        try:
            refined = mend(self.on_few(control), control, FEWER_ROUNDS)
        except MeshError:
            return images
        ours, theirs = (reduction(one.shape, FEW_VERTICES) for one in self.openings)
        return self._map.images(start=theirs.vertices[refined.images[ours.index_of_vertex]])


_Refined = tuple[OpenedCandidate, Fit]
"""A candidate, and its fit once it is refined on few vertices."""


def _of_whole(found: Images, here: Opening, there: Opening) -> Images:
    """Return images of what is left of a shape as those of the whole shape."""
    (images, faces, barycentric), rows = found, here.index_of_vertex
    return there.vertices[images[rows]], there.faces[faces[rows]], barycentric[rows]


def search_opened(
    source: Shape,
    target: Shape,
    known: VertexMaps,
    rematch: Rematch,
    score: float,
    control: Control,
) -> tuple[OpenedCandidate, Confidence] | None:
    """Search for the candidate that fits best on surfaces that are opened where parts touch.

    Parameters
    ----------
    source, target
        The whole shapes.
    known
        Maps of the answer for them, which is opened where these tear it: one more candidate.
    rematch
        Finds hypotheses on what is left of them.
    score
        Of the refined fit, that the best is to have at most.
    control
        May cancel; past its deadline, less is tried.

    Returns
    -------
    The best, and the confidence in it, whose measures have the refined fit; ``None`` if neither
    surface has anything to open, or too little besides, or none fits so well.

    Raises
    ------
    Cancelled
        Through `control`.
    MeshError
        A Laplacian cannot be factored.
    """
    ours, theirs = reduction(source), reduction(target)
    maps = reduced_maps(known, ours, theirs)
    refined = _refined_where_torn(ours.shape, theirs.shape, maps, control)
    confidence = None
    for number, crease in enumerate(control.in_time(CREASES, least=1)):
        part = control.between(number / len(CREASES), (number + 1) / len(CREASES))
        refined += _refined_candidates(ours.shape, theirs.shape, rematch, crease, part)
        refined.sort(key=lambda one: one[1].score)
        if refined and refined[0][1].score <= score:
            confidence = _confidence_in(refined, ours.shape, theirs.shape, control)
            if confidence.is_sure:
                break
    if confidence is None:
        return None
    best = refined[0][0]
    if ours.shape is source and theirs.shape is target:
        return best, confidence
    found = whole_maps(best.vertex_maps(), ours, theirs)
    return _reopened(source, target, found, control), confidence


def _refined_where_torn(
    source: Shape, target: Shape, maps: VertexMaps, control: Control
) -> list[_Refined]:
    """The candidate of maps on surfaces that are opened where these tear them.

    None if they tear neither, or what is left cannot be displaced.
    """
    try:
        found = _reopened(source, target, maps, control)
        ours, theirs = (one.shape for one in found.openings)
        if ours is source and theirs is target:
            return []
        return [(found, found.on_few(control).fit)]
    except MeshError:
        return []


def _refined_candidates(
    source: Shape, target: Shape, rematch: Rematch, crease: Crease, control: Control
) -> list[_Refined]:
    """Candidates on opened surfaces, refined on few vertices.

    None if neither surface has anything to open, or what is left cannot be displaced.
    """
    ours, theirs = (
        Opening.at(shape, creases(smooth_surface(shape), crease)) for shape in (source, target)
    )
    if ours.shape is source and theirs.shape is target:
        return []
    try:
        task = Task.of(ours.shape, theirs.shape)
        reduced = partial(ReducedTask.of, ours.shape, theirs.shape, task)
        hypotheses = rematch(ours.shape, theirs.shape)
        searched = search(task, reduced, hypotheses, control, others=False)
        found = [
            _reopened(source, target, OpenedCandidate((ours, theirs), one).vertex_maps(), control)
            for one in control.in_time(searched.candidates, least=1)
        ]
        found.sort(key=lambda one: one.candidate.fit.score)
        return [(one, one.on_few(control).fit) for one in control.in_time(found, least=1)]
    except MeshError:
        return []


def _confidence_in(
    refined: Sequence[_Refined], source: Shape, target: Shape, control: Control
) -> Confidence:
    """Confidence in the first of candidates, by itself and those that differ from it."""
    positions = smooth_surface(target).mesh.vertices
    every = np.arange(source.n_vertices)
    rows = distinct(positions[one.images(every, control)] for one, _ in refined)
    return refined_confidence(
        confidence_in([refined[row][0].candidate for row in rows], control),
        refined[0][1],
        margin_of([refined[row][1].score for row in rows]),
        complete=not control.expired,
    )


def _reopened(source: Shape, target: Shape, maps: VertexMaps, control: Control) -> OpenedCandidate:
    """Open both surfaces where the maps of a candidate tear them, and align it once more."""
    ours, theirs = maps.openings(source, target)
    task = Task.of(ours.shape, theirs.shape)
    images = theirs.index_of_vertex[maps.images[ours.vertices]]
    back = ours.index_of_vertex[maps.back[theirs.vertices]]
    found = choose(task, mapped(task, images, back), _STAGES, control)[0]
    return OpenedCandidate((ours, theirs), found)
