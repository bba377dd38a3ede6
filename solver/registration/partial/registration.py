"""Registration of a whole to a part of it: the front door of this package."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.mesh import vertex_normals
from solver.registration.candidates import MIN_POINTS
from solver.registration.confidence import Confidence
from solver.registration.partial.alignment import WEIGHTS, PartSamples, find_pairs
from solver.registration.partial.confidence import part_confidence
from solver.registration.partial.fit import RefinedPartFit, changes_of_curvature
from solver.registration.partial.search import FINE, PartCandidate, search_part
from solver.registration.registration import DenseCorrespondence, in_numbers_of_files
from solver.registration.surface import SmoothSurface, smooth_surface
from solver.registration.surface_map import SurfaceMap
from solver.shape import Shape

_NEAR = 0.03
"""Distance over √area of the whole within which a vertex' partner's partner is near it: between
0.02 and 0.05, the F1 score of vertices without partner changes by two hundredths."""


Images = tuple[IntArray, IntArray, FloatArray]
"""(V,) nearest vertices, (V,) triangles and (V, 3) barycentric coordinates."""


@dataclass(frozen=True, eq=False)
class PartMap:
    """Maps of all vertices between a whole and a part of it.

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
    confidence: Confidence

    def dense(self, part_is_source: bool) -> DenseCorrespondence:
        """Return the maps in the user's numbers; of the whole, what is covered."""
        whole, part = self.whole.mesh, self.part.mesh
        to_part = in_numbers_of_files(whole, part, *self.to_part, self.covered)
        to_whole = in_numbers_of_files(part, whole, *self.to_whole)
        forward, back = (to_whole, to_part) if part_is_source else (to_part, to_whole)
        return replace(forward, inverse=back)


def register_part(
    whole: Shape, part: Shape, control: Control, scale: float | None = None
) -> PartMap | None:
    """Register a whole to a part of it: bend it so that the part lies on it, at the part's scale.

    Parameters
    ----------
    whole, part
        The shapes; the unit of length of either does not matter.
    control
        May cancel; past its deadline, less is tried.
    scale
        √area of the whole over √area of the part, if it is known.

    Returns
    -------
    PartMap
        ``None`` if a shape has too few vertices.

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
    refined = [
        _refined(ours, theirs, one, control)
        for one in control.in_time(search_part(whole, part, control, scale), least=1)
    ]
    refined.sort(key=lambda one: one.fit.score)
    chosen = refined[0].again(control)
    mass = ours.spectrum.mass
    return PartMap(
        whole,
        part,
        chosen.scale,
        (chosen.images, *chosen.displaced.on_triangles(chosen.images)),
        chosen.covered,
        float(mass[chosen.covered].sum() / mass.sum()),
        chosen.back,
        part_confidence([one.fit for one in refined], complete=not control.expired),
    )


@dataclass(frozen=True, eq=False)
class _Refined:
    """A candidate whose displacement was refined, with its images and its fit."""

    displaced: SurfaceMap
    scale: float
    images: IntArray
    back: Images
    fit: RefinedPartFit

    @cached_property
    def covered(self) -> BoolArray:
        """(V,) vertices of the whole that have a partner."""
        return _covered(self.displaced, self.images, self.back[0])

    def again(self, control: Control) -> "_Refined":
        """Refine it once more, drawn by what has a partner by now."""
        rigid = self.displaced.at_rest(self.scale, self.covered)
        displaced, images = self.displaced.refined(rigid, control)
        return replace(self, displaced=displaced, images=images, back=displaced.inverse())


def _refined(
    whole: SmoothSurface, part: SmoothSurface, candidate: PartCandidate, control: Control
) -> _Refined:
    known = SurfaceMap.of(whole, part, candidate.alignment, reflected=False)
    images = known.images()
    rigid = known.at_rest(candidate.scale, _covered(known, images, known.inverse()[0]))
    displaced, images = known.refined(rigid, control)
    back = displaced.inverse()
    samples = whole.samples.first(FINE[-1].whole_samples)
    points = PartSamples.of(part, FINE[-1].part_samples)
    pairs = find_pairs(samples, points, candidate.alignment, candidate.scale, WEIGHTS)
    bent = changes_of_curvature(samples, part.samples, pairs, candidate.scale)
    fit = _fit_of(displaced, back, rigid.strain(displaced.positions), bent)
    return _Refined(displaced, candidate.scale, images, back, fit)


def _fit_of(
    displaced: SurfaceMap, back: Images, strained: float, bent: tuple[float, ...]
) -> RefinedPartFit:
    whole, part = displaced.source, displaced.target
    vertices, faces, barycentric = back
    corners = displaced.positions[whole.mesh.faces[faces]]
    places = np.einsum("vc,vcd->vd", barycentric, corners)
    normals = whole.side * vertex_normals(displaced.positions, whole.mesh.faces)
    cosines = (normals[vertices] * part.normals).sum(axis=1)
    return RefinedPartFit(
        float(np.linalg.norm(places - part.mesh.vertices, axis=1).mean()),
        float(np.sqrt(2.0 * max(1.0 - cosines.mean(), 0.0))),
        strained,
        bent,
    )


def _covered(known: SurfaceMap, images: IntArray, back: IntArray) -> BoolArray:
    """(V,) vertices that have a partner: inside the part, and their partner's partner is near."""
    positions, mesh = known.source.mesh.vertices, known.target.mesh
    apart = np.linalg.norm(positions - positions[back[images]], axis=1)
    faces, barycentric = known.on_triangles(images)
    inside = (barycentric * ~mesh.on_boundary[mesh.faces[faces]]).sum(axis=1)
    return np.asarray((apart < _NEAR) & (inside > 0.0))
