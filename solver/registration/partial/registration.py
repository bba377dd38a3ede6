"""Registration of a whole to a part of it, or of two parts: the front door of this package."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.mesh import TriangleMesh, vertex_normals
from solver.registration.candidates import MIN_POINTS, NO_LANDMARKS, Points
from solver.registration.choice import SAME
from solver.registration.confidence import Confidence
from solver.registration.partial.alignment import WEIGHTS, PartSamples, find_pairs
from solver.registration.partial.choice import PartCandidate
from solver.registration.partial.confidence import part_confidence
from solver.registration.partial.fit import RefinedPartFit, changes_of_curvature, mean_share
from solver.registration.partial.search import FINEST, search_part
from solver.registration.registration import DenseCorrespondence, in_numbers_of_files
from solver.registration.surface import SmoothSurface, smooth_surface
from solver.registration.surface_map import SurfaceMap
from solver.shape import Shape

_NEAR = 0.03
"""Distance over √area of the whole within which a vertex' partner's partner is near it: between
0.02 and 0.05, the F1 score of vertices without partner changes by two hundredths."""

_APART = 0.015
"""Distance over √area of the whole within which partners meet, once displaced, of surfaces that
overlap. On 14 generated pairs, the F1 score is 0.76 without, 0.775 with 0.02, 0.79 with 0.01."""


_CLOSE = 0.1
"""By how much the score of a crossed candidate must be less. With 0 instead, one more of 68 parts,
of people and animals, generated and scanned, is wrong."""

Images = tuple[IntArray, IntArray, FloatArray]
"""(V,) nearest vertices, (V,) triangles and (V, 3) barycentric coordinates."""


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
    confidence: Confidence

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
    scale: float | None = None,
    entire: bool = True,
    landmarks: Points = NO_LANDMARKS,
) -> PartMap | None:
    """Register a whole to a part of it: bend it so that the part lies on it, at the part's scale.

    Or register two parts that overlap: the one called whole here is bent, best that with less
    boundary.

    Parameters
    ----------
    whole, part
        The shapes; the unit of length of either does not matter.
    control
        May cancel; past its deadline, less is tried.
    scale
        √area of the whole over √area of the part, if it is known.
    entire
        Whether every point of the part has a partner. Else the surfaces overlap, and neither is a
        part of the other.
    landmarks
        Vertices of the whole and of the part that correspond.

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
    ours, theirs = smooth_surface(whole), smooth_surface(part)
    if min(ours.samples.size, theirs.samples.size) <= MIN_POINTS:
        return None
    known, crossed = search_part(whole, part, control, scale, entire, landmarks)
    if not known:
        return None
    # Some candidates were found either way.
    both = dict.fromkeys([*known, *crossed])
    displaced = {
        one: _refined(ours, theirs, one, entire, control) for one in control.in_time(both, least=1)
    }
    refined = _best_first(
        ours,
        *([displaced[one] for one in found if one in displaced] for found in (known, crossed)),
    )
    chosen = refined[0].again(control)
    return PartMap(
        whole,
        part,
        chosen.scale,
        (chosen.images, *chosen.displaced.on_triangles(chosen.images)),
        chosen.covered,
        _share(ours, chosen.covered),
        chosen.back,
        chosen.part_covered,
        _share(theirs, chosen.part_covered),
        part_confidence([one.fit for one in refined], entire, complete=not control.expired),
    )


@dataclass(frozen=True, eq=False)
class _Refined:
    """A candidate whose displacement was refined, with its images.

    Parameters
    ----------
    displaced, scale
        The displaced whole, and its √area in the part's unit.
    images, back
        Of all vertices of the whole, and of all of the part.
    entire
        Whether every point of the part has a partner.
    strained, bent
        As of :class:`.RefinedPartFit`.
    """

    displaced: SurfaceMap
    scale: float
    images: IntArray
    back: Images
    entire: bool
    strained: float
    bent: tuple[float, ...]

    @cached_property
    def covered(self) -> BoolArray:
        """(V,) vertices of the whole that have a partner."""
        found = _covered(self.displaced, self.images, self.back[0])
        if self.entire:
            return found
        found &= _met(self.displaced, self.images, self.scale)
        return largest_patch(self.displaced.source, found)

    @cached_property
    def part_covered(self) -> BoolArray:
        """(W,) vertices of the part that have a partner."""
        if self.entire:
            return np.ones(len(self.back[0]), dtype=np.bool_)
        found = _part_covered(self.displaced, self.images, self.back, self.scale)
        return largest_patch(self.displaced.target, found)

    @cached_property
    def fit(self) -> RefinedPartFit:
        """Its fit."""
        whole, part = self.displaced.source, self.displaced.target
        met = self.part_covered
        if not met.any():
            return RefinedPartFit.of_nothing(len(self.bent))
        vertices, faces, barycentric = self.back
        places = _places(self.displaced.positions, whole, faces[met], barycentric[met])
        normals = whole.side * vertex_normals(self.displaced.positions, whole.mesh.faces)
        cosines = (normals[vertices[met]] * part.normals[met]).sum(axis=1)
        shares = _share(whole, self.covered), _share(part, met)
        return RefinedPartFit(
            float(np.linalg.norm(places - part.mesh.vertices[met], axis=1).mean()),
            float(np.sqrt(2.0 * max(1.0 - cosines.mean(), 0.0))),
            self.strained,
            self.bent,
            1.0 if self.entire else mean_share(*shares, self.scale),
        )

    def again(self, control: Control) -> "_Refined":
        """Refine it once more, drawn by what has a partner by now."""
        rigid = self.displaced.at_rest(self.scale, self.covered if self.covered.any() else None)
        displaced, images = self.displaced.refined(rigid, control)
        return replace(self, displaced=displaced, images=images, back=displaced.inverse())


def _refined(
    whole: SmoothSurface,
    part: SmoothSurface,
    candidate: PartCandidate,
    entire: bool,
    control: Control,
) -> _Refined:
    known = SurfaceMap.of(whole, part, candidate.alignment, reflected=False)
    images = known.images()
    covered = _covered(known, images, known.inverse()[0])
    if not entire:
        covered = largest_patch(whole, covered)
    rigid = known.at_rest(candidate.scale, covered if covered.any() else None)
    displaced, images = known.refined(rigid, control)
    samples = whole.samples.first(FINEST.whole_samples)
    points = PartSamples.of(part, FINEST.part_samples, entire)
    pairs = find_pairs(samples, points, candidate.alignment, candidate.scale, WEIGHTS)
    bent = changes_of_curvature(samples, part.samples, pairs, candidate.scale)
    strained = rigid.strain(displaced.positions)
    return _Refined(displaced, candidate.scale, images, displaced.inverse(), entire, strained, bent)


def _best_first(
    whole: SmoothSurface, known: Sequence[_Refined], crossed: Sequence[_Refined]
) -> list[_Refined]:
    """Candidates, the best first: a crossed one, if it is clearly better than those known.

    Where there are crossed ones, those that are the same as a better one are left out.
    """
    order = sorted(known, key=lambda one: one.fit.score)
    if not crossed:
        return order
    everything = sorted([*order, *crossed], key=lambda one: one.fit.score)
    if everything[0].fit.score > order[0].fit.score - _CLOSE:
        everything.insert(0, order[0])
    positions = whole.mesh.vertices
    chosen: list[_Refined] = []
    for one in everything:
        here = positions[one.back[0]]
        if all(
            np.linalg.norm(positions[better.back[0]] - here, axis=1).mean() > SAME
            for better in chosen
        ):
            chosen.append(one)
    return chosen


def _covered(known: SurfaceMap, images: IntArray, back: IntArray) -> BoolArray:
    """(V,) vertices that have a partner: inside the part, and their partner's partner is near."""
    positions = known.source.mesh.vertices
    apart = np.linalg.norm(positions - positions[back[images]], axis=1)
    return np.asarray((apart < _NEAR) & _inside(known.target.mesh, *known.on_triangles(images)))


def _met(known: SurfaceMap, images: IntArray, scale: float) -> BoolArray:
    """(V,) vertices that meet their partners."""
    places = _places(known.target.mesh.vertices, known.target, *known.on_triangles(images))
    apart = np.linalg.norm(places - known.positions, axis=1)
    return np.asarray(apart < _APART * scale)


def _part_covered(known: SurfaceMap, images: IntArray, back: Images, scale: float) -> BoolArray:
    """(W,) vertices of the part that have a partner, by the same rules."""
    vertices, faces, barycentric = back
    positions = known.target.mesh.vertices
    around = np.linalg.norm(positions - positions[images[vertices]], axis=1)
    places = _places(known.positions, known.source, faces, barycentric)
    apart = np.linalg.norm(places - positions, axis=1)
    near = (around < _NEAR * scale) & (apart < _APART * scale)
    return np.asarray(near & _inside(known.source.mesh, faces, barycentric))


def _places(
    positions: FloatArray, surface: SmoothSurface, faces: IntArray, barycentric: FloatArray
) -> FloatArray:
    """(N, 3) places of points in triangles, from the positions of the vertices."""
    corners = positions[surface.mesh.faces[faces]]
    places: FloatArray = np.einsum("vc,vcd->vd", barycentric, corners)
    return places


def _inside(mesh: TriangleMesh, faces: IntArray, barycentric: FloatArray) -> BoolArray:
    """(N,) points that lie inside a surface, not on its boundary."""
    inside: FloatArray = (barycentric * ~mesh.on_boundary[mesh.faces[faces]]).sum(axis=1)
    return np.asarray(inside > 0.0)


def largest_patch(surface: SmoothSurface, covered: BoolArray) -> BoolArray:
    """(V,) the vertices that belong to the largest patch of a surface, by area.

    Limbs that either surface lacks are free to be bent onto one another; what is between them and
    the rest has no partner then.

    Parameters
    ----------
    surface
        V vertices.
    covered
        (V,) vertices; those of a patch are at most two edges from one another.
    """
    ends = surface.mesh.edges
    reached = covered.copy()
    reached[ends[covered[ends].any(axis=1)]] = True
    ends = ends[reached[ends].all(axis=1)]
    graph = coo_array((np.ones(len(ends)), ends.T), shape=(len(covered),) * 2)
    patch = connected_components(graph, directed=False)[1]
    areas = np.bincount(patch, np.where(covered, surface.spectrum.mass, 0.0))
    return np.asarray(covered & (patch == areas.argmax()))


def _share(surface: SmoothSurface, covered: BoolArray) -> float:
    mass = surface.spectrum.mass
    return float(mass[covered].sum() / mass.sum())
