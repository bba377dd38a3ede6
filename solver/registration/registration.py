"""Registration of two shapes: the front door of this package."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.errors import MeshError
from solver.mesh import TriangleMesh
from solver.registration.alignment import GLOBAL, Pairs
from solver.registration.candidates import MIN_POINTS, NO_LANDMARKS, Points, first_pairs
from solver.registration.choice import COARSE, LANDMARK, Candidate, Task, again, choose
from solver.registration.confidence import SURE, Confidence
from solver.registration.glued import OpenedCandidate, Rematch, search_opened
from solver.registration.opening import Opening
from solver.registration.reduction import ReducedTask
from solver.registration.refinement import refine_candidate
from solver.registration.search import search
from solver.registration.surface import Samples, smooth_surface
from solver.shape import Shape

_REFLECTED_MARGIN = 3.0
"""How much less the score of the reflected source must be for the shapes to be called reflected:
the measures less by two fifths each. A symmetric body in a mirrored pose fits somewhat better
reflected, too."""

_REFLECTED_KEPT = 4
"""Candidates of the reflected source that are kept after the first stage: a reflected copy fits far
better than any other."""


@dataclass(frozen=True, eq=False)
class DenseCorrespondence:
    """A map of all vertices, and its inverse.

    Parameters
    ----------
    source
        (K,) the user's numbers of all vertices of the source's surface, ascending, but of those
        without a partner on a part.
    target
        (K,) the user's number of the vertex nearest to each one's image; several may have the same.
    faces
        (K, 3) the user's numbers of the corners of the target's triangle that the image lies in.
    barycentric
        (K, 3) float64 barycentric coordinates of the image there; each row sums to 1.
    hypothesis
        Hypothesis that agrees best with the map: 0 for the match's best, or one more than a place
        among its alternatives.
    inverse
        The map of all vertices of the target to the source, by the same registration: its `source`
        are vertices of the target, and its own `inverse` is ``None``.
    """

    source: IntArray
    target: IntArray
    faces: IntArray
    barycentric: FloatArray
    hypothesis: int = 0
    inverse: "DenseCorrespondence | None" = None


@dataclass(frozen=True, eq=False)
class Registration:
    """A source registered to a target.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    candidate
        The chosen one.
    reflected
        Whether the source is reflected in space.
    confidence
        That the chosen one is right.
    openings
        What is left of both where they were opened, as parts of them touch: that is what the
        candidates map.
    """

    source: Shape
    target: Shape
    candidate: Candidate
    reflected: bool
    confidence: Confidence
    openings: tuple[Opening, Opening] | None = None

    @property
    def score(self) -> float:
        """Score of the chosen candidate's fit; the less, the better."""
        return self.candidate.fit.score

    def images(self, vertices: IntArray) -> IntArray:
        """(S,) target vertices that S source vertices go to, refined where they are torn."""
        return self._chosen.images(vertices)

    @cached_property
    def _chosen(self) -> OpenedCandidate:
        whole = Opening.nowhere(self.source), Opening.nowhere(self.target)
        return OpenedCandidate(self.openings or whole, self.candidate, self.reflected)

    def dense(self, control: Control) -> DenseCorrespondence:
        """Map all vertices of both surfaces, refined beyond the eigenfunctions.

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
        here, there = self._chosen.openings
        refined = refine_candidate(self._chosen.task, self.candidate, control)
        source, target = self.source.mesh, self.target.mesh
        forward = _of_whole(here, there, *refined.forward)
        back = _of_whole(there, here, *refined.back)
        return replace(
            in_numbers_of_files(source, target, *forward),
            inverse=in_numbers_of_files(target, source, *back),
        )


def register(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[Points],
    control: Control,
    landmarks: Points = NO_LANDMARKS,
    *,
    others: bool = True,
    rematch: Rematch | None = None,
) -> Registration | None:
    """Register a source to a target: bend it onto the target in space, and see how well it fits.

    Candidates begin at the hypotheses, at signs of eigenfunctions, and at a rotation in space.
    Those registered best are registered more finely, and the one that fits best is chosen: the
    direct one, wherever the surfaces tell left from right and front from back, as displacements
    reflect nothing. Where landmarks are given, or it fits better coarsely, the reflected source is
    registered as well: it is the answer if it alone meets the landmarks, or fits far better. In
    doubt, more candidates are searched, and chosen from by their refinement (:mod:`.search`).

    Parameters
    ----------
    source, target
        The shapes X and Y.
    hypotheses
        (n,) vertices of X and (n,) vertices of Y that correspond, as many as there are.
    control
        May cancel; past its deadline, less is tried.
    landmarks
        Vertices of X and Y that are known to correspond: candidates that miss them come last.
    others
        Whether another population of candidates is searched when the answer is in doubt.
    rematch
        Finds hypotheses on surfaces that are opened where parts of them touch: where one surface
        has handles, the other none, and the refined answer is still in doubt, it is searched there
        as well (:func:`.search_opened`).

    Returns
    -------
    Registration
        ``None`` if neither hypotheses nor eigenfunctions tell where to begin.

    Raises
    ------
    Cancelled
        Through `control`.

    References
    ----------
    Compare Eisenberger, Lähner and Cremers, "Smooth Shells: Multi-scale shape registration with
    functional maps", CVPR 2020, whose first candidates are random.
    """
    task = _task(source, target, landmarks)
    if min(one.size for one in task.samples) <= MIN_POINTS:
        return None
    found = _registered(source, target, task, hypotheses, control, others)
    if len(landmarks[0]):
        # Landmarks may mean the mirror image.
        mirrored = _registered(source, target, task.reflected(), hypotheses, control, False)
        return mirrored if _is_meant(mirrored, found) else found
    if control.expired:
        return found
    if _may_be_reflected(task, found.candidate, control):
        mirrored = _registered(source, target, task.reflected(), hypotheses, control, others)
        if mirrored.score < found.score - _REFLECTED_MARGIN:
            return replace(mirrored, confidence=mirrored.confidence.of_reflection())
    return found if rematch is None else _opened(found, rematch, control)


def _task(source: Shape, target: Shape, landmarks: Points = NO_LANDMARKS) -> Task:
    ours, theirs = smooth_surface(source), smooth_surface(target)
    return Task(ours, theirs, (ours.samples, theirs.samples), landmarks)


def _of_whole(
    here: Opening, there: Opening, images: IntArray, faces: IntArray, barycentric: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return a map of what is left of a shape as one of the whole shape."""
    places = here.places
    return there.vertices[images[places]], there.faces[faces[places]], barycentric[places]


def in_numbers_of_files(
    source: TriangleMesh,
    target: TriangleMesh,
    images: IntArray,
    faces: IntArray,
    barycentric: FloatArray,
    mapped: BoolArray | None = None,
) -> DenseCorrespondence:
    """Return a map of vertices in the user's numbers, those of merged vertices included.

    Parameters
    ----------
    source, target
        The meshes.
    images, faces, barycentric
        (V,), (V,) and (V, 3) nearest vertices, triangles and coordinates of all source vertices.
    mapped
        (V,) source vertices that have an image, by default all.
    """
    ids, vertices = source.numbering
    if mapped is not None:
        ids, vertices = ids[mapped[vertices]], vertices[mapped[vertices]]
    number = target.vertex_ids
    return DenseCorrespondence(
        ids,
        number[images[vertices]],
        number[target.faces[faces[vertices]]],
        barycentric[vertices],
    )


def _is_meant(mirrored: Registration, direct: Registration) -> bool:
    """Return whether landmarks mean the mirror image: it alone meets them, or fits far better."""
    nearer = direct.candidate.missed - mirrored.candidate.missed
    if abs(nearer) > LANDMARK:
        return nearer > 0.0
    return mirrored.score < direct.score - _REFLECTED_MARGIN


def _may_be_reflected(task: Task, direct: Candidate, control: Control) -> bool:
    """Return whether the reflected source fits better than the direct answer, coarsely.

    Without hypotheses: signs of eigenfunctions tell a reflected copy, which is an isometric one.
    """

    def signs(samples: tuple[Samples, Samples]) -> Iterator[Pairs]:
        return first_pairs((task.source, task.target), samples, ())

    stages = replace(COARSE[0], kept=_REFLECTED_KEPT), *COARSE[1:]
    mirrored = choose(task.reflected(), signs, stages, control)[0].fit.score
    coarse = choose(task, again([direct], GLOBAL), COARSE, control)[0].fit.score
    return mirrored < coarse - _REFLECTED_MARGIN


def _registered(
    source: Shape,
    target: Shape,
    task: Task,
    hypotheses: Sequence[Points],
    control: Control,
    others: bool,
) -> Registration:
    reduced = partial(ReducedTask.of, source, target, task)
    found = search(task, reduced, hypotheses, control, others=others)
    return Registration(source, target, found.candidates[0], task.is_reflected, found.confidence)


def _opened(known: Registration, rematch: Rematch, control: Control) -> Registration:
    """Register what is left of a surface that is glued, in doubt, if that fits better, refined.

    One of the two is glued if it has handles and the other none. Where both have, tears of one say
    nothing of the other, and as many answers become wrong as right.
    """
    glued = [shape.mesh.genus > 0.0 for shape in (known.source, known.target)]
    score = known.confidence.measures.get("refined_score")
    if score is None or glued[0] == glued[1]:
        return known
    if known.confidence.probability >= SURE or control.expired:
        return known
    try:
        found = search_opened(known.source, known.target, rematch, score, control)
    except MeshError:
        # What cannot be opened stays closed; the answer for it stands.
        return known
    if found is None:
        return known
    return replace(
        known,
        candidate=found.opened.candidate,
        confidence=found.confidence,
        openings=found.opened.openings,
    )
