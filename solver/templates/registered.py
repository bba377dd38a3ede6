"""Template registration: the connectivity of the source on the surface of the target."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.control import Control
from solver.errors import OptionError
from solver.mesh import TriangleMesh, face_normals, surface_tree, triangle_areas, vertex_normals
from solver.registration import DenseCorrespondence
from solver.templates.folds import (
    Connectivity,
    Placement,
    Surface,
    corner_qualities,
    embed,
    placed,
    qualities,
    relax,
)

_BAD = 0.02
"""Quality below which triangles are relaxed, unless they are as bad in the template: a triangle of
this quality has a height of a hundredth of its length."""

_RINGS = 1, 3
"""Rings of triangles round bad ones that are relaxed with them, one number after another: few
change least, many untangle most."""

_ROUNDS = 20
"""Rounds in which ε falls, with each number of rings."""

_FIRST, _FALL, _LAST = 0.5, 0.8, 1e-3
"""ε at first, its ratio in each round, and the least."""

_GREATEST_PATCH = 15
"""Rings of triangles round flipped ones, at most, that are embedded anew."""

_SWEEPS = 100
"""Sweeps over the vertices of a patch that is embedded anew."""

_BLOCK = 200
"""Vertices that move, or triangles whose quality is computed, between two looks at the clock."""

_HOPELESS = 0.01
"""Share of flipped triangles above which nothing is embedded anew: the map is far from one-to-one,
and patches would cover the surface."""


@dataclass(frozen=True, eq=False)
class RegisteredTemplate:
    """A template registered to a target: its connectivity on the target's surface.

    Parameters
    ----------
    positions
        (V, 3) vertices of the template's mesh on the target, in the target's units.
    flipped
        (F,) triangles that are flipped: their normals make more than a right angle with that of the
        target's triangle nearest to their centre; where several are as near, as on an edge, with
        those of all. Triangles without an area count as flipped.
    reflected
        Whether the template is reflected in space. That its winding is opposite does not say so:
        that of an open surface is as in its file.
    """

    positions: FloatArray
    flipped: BoolArray
    reflected: bool


class _Folds(NamedTuple):
    """Triangles that disagree with the surface they lie on.

    At a crease, which has several normals, `flipped` triangles disagree with all of them, and
    `folded` ones with one at least: it is better to agree with both sides.
    """

    positions: FloatArray
    flipped: BoolArray
    folded: BoolArray


def register_template(
    template: TriangleMesh,
    target: TriangleMesh,
    dense: DenseCorrespondence,
    control: Control | None = None,
) -> RegisteredTemplate:
    """Move a template's vertices to their images, and relax the folds that arise there.

    Images are not one-to-one: where several vertices have nearly the same image, triangles fold.
    Vertices around such triangles move along the surface until no triangle is flipped; all others
    stay at their images. Some maps that are far from one-to-one leave flipped triangles; others,
    and wrong ones, leave none: see :func:`surface_distance`.

    Parameters
    ----------
    template, target
        The meshes that were matched.
    dense
        Map from the template to the target, of all vertices of the template.
    control
        May cancel; past its deadline, folds remain, but no more than the images have.

    Raises
    ------
    OptionError
        The map is of other meshes.
    Cancelled
        Through `control`.
    """
    control = control or Control()
    size = np.sqrt(target.area)
    surface = _surface(target)
    images = _placement(template, target, dense, surface)
    inverted = _inverted(images, template.faces)
    mesh = _connectivity(template, inverted)
    positions, flipped = _relaxed(images, mesh, surface, _least_qualities(template), control)
    return RegisteredTemplate(
        positions * size + _centre(target),
        flipped,
        inverted and _is_reflection(template.vertices, positions),
    )


def _is_reflection(template: FloatArray, positions: FloatArray) -> bool:
    """Return whether the orthogonal map that fits best reflects (Kabsch, 1976)."""
    before, after = (one - one.mean(axis=0) for one in (template, positions))
    return bool(np.linalg.det(before.T @ after) < 0.0)


def _relaxed(
    images: Placement,
    mesh: Connectivity,
    surface: Surface,
    least: FloatArray,
    control: Control,
) -> tuple[FloatArray, BoolArray]:
    """Return (V, 3) positions without folds, and (F,) the triangles that are flipped yet.

    Single moves cannot turn a patch that has collapsed inside out. Such patches are embedded anew,
    larger ones as long as triangles stay flipped, and relaxed again.
    """
    placement = images.copied()
    given = state = _folds(placement, mesh.faces, surface, control)
    found: list[_Folds] = []
    for rings in control.in_time(range(_GREATEST_PATCH + 1)):
        if rings:
            folded = np.flatnonzero(state.folded)
            patch = _vertices_round(mesh.faces, folded, len(images.positions), rings - 1)
            inner = patch[~mesh.on_boundary[patch]]
            for _ in control.in_time(range(_SWEEPS)):
                embed(placement, inner, mesh, surface)
        for everywhere in control.in_time((False, True)):
            _relax_folds(placement, mesh, surface, everywhere, least, rings, control)
        state = _folds(placement, mesh.faces, surface, control)
        found.append(state)
        if not state.folded.any() or state.flipped.sum() > _HOPELESS * len(mesh.faces):
            break
    # Of equals the first is taken: the images only where each relaxation has made them worse.
    best = min([*found, given], key=lambda one: (one.flipped.sum(), one.folded.sum()))
    return best.positions, best.flipped


def _folds(placement: Placement, faces: IntArray, surface: Surface, control: Control) -> _Folds:
    """Find the folds that a placement has, also past the deadline."""
    positions = placement.positions
    centres, normals = positions[faces].mean(axis=1), face_normals(positions, faces)
    cosines = np.empty((2, len(faces)))
    for block in _blocks(np.arange(len(faces)), replace(control, deadline=None)):
        cosines[:, block] = surface.tree.cosines(centres[block], normals[block])
    worst, agreeing = cosines
    return _Folds(positions.copy(), agreeing <= 0.0, worst <= 0.0)


def _relax_folds(
    placement: Placement,
    mesh: Connectivity,
    surface: Surface,
    everywhere: bool,
    least: FloatArray,
    attempt: int,
    control: Control,
) -> None:
    """Relax the triangles of a quality below the least, by the normals at the corners or all."""
    faces = mesh.faces
    bounds = np.stack([least, np.full(len(least), 1e-9)], axis=1)
    bad = np.zeros((len(faces), 2), dtype=np.bool_)

    def judge(chosen: IntArray) -> None:
        for block in _blocks(chosen, control):
            bad[block] = qualities(placement, faces, block, surface, everywhere) < bounds[block]

    judge(np.arange(len(faces)))
    for number in control.in_time(range(len(_RINGS) * _ROUNDS)):
        folded = np.flatnonzero(bad.any(axis=1))
        if not len(folded):
            return
        rings, step = divmod(number, _ROUNDS)
        vertices = _vertices_round(faces, folded, len(placement.positions), _RINGS[rings])
        epsilon, turn = max(_FIRST * _FALL**step, _LAST), float(step) + 0.37 * attempt
        moved = np.zeros(len(placement.positions), dtype=np.bool_)
        for block in _blocks(vertices, control):
            moved[block] = relax(placement, block, mesh, surface, everywhere, epsilon, turn)
        judge(np.flatnonzero(moved[faces].any(axis=1)))


def _blocks(chosen: IntArray, control: Control) -> Iterator[IntArray]:
    """Yield vertices or triangles in blocks, in order, until the deadline."""
    starts = range(0, len(chosen), _BLOCK)
    return control.in_time(chosen[start : start + _BLOCK] for start in starts)


def _vertices_round(faces: IntArray, bad: IntArray, count: int, rings: int) -> IntArray:
    """Vertices of bad triangles, and those within so many rings of triangles round them."""
    marked = np.zeros(count, dtype=np.bool_)
    marked[faces[bad]] = True
    for _ in range(rings):
        marked[faces[marked[faces].any(axis=1)]] = True
    return np.flatnonzero(marked)


def _surface(target: TriangleMesh) -> Surface:
    """Return a surface of unit area."""
    vertices, normals = _of_unit_area(target)
    tree = surface_tree(vertices, target.faces)
    around = (*target.neighbours, *target.incident_faces)
    return Surface(vertices, target.faces, normals, *around, tree)


def _of_unit_area(mesh: TriangleMesh) -> tuple[FloatArray, FloatArray]:
    """(V, 3) vertices of a mesh, scaled and centred, and their normals."""
    vertices = (mesh.vertices - _centre(mesh)) / np.sqrt(mesh.area)
    return vertices, vertex_normals(vertices, mesh.faces)


def _connectivity(template: TriangleMesh, inverted: bool) -> Connectivity:
    faces = template.faces[:, ::-1] if inverted else template.faces
    around = (*template.edge_neighbours, *template.incident_faces)
    areas = np.repeat(triangle_areas(template.vertices, template.faces), 3) / template.area
    corners = template.faces.ravel()
    means = np.bincount(corners, areas) / np.bincount(corners)
    return Connectivity(np.ascontiguousarray(faces), 2.0 * means, template.on_boundary, *around)


def _placement(
    template: TriangleMesh, target: TriangleMesh, dense: DenseCorrespondence, surface: Surface
) -> Placement:
    """Return the template's vertices at their images."""
    rows = np.searchsorted(dense.source, template.vertex_ids).clip(max=len(dense.source) - 1)
    corners = target.vertices_of(dense.faces[rows].ravel()).reshape(-1, 3)
    if (dense.source[rows] != template.vertex_ids).any() or corners.min() < 0:
        raise OptionError("dense", "the map is not of all vertices of this template and target")
    weights = dense.barycentric[rows]
    images = np.einsum("vc,vcd->vd", weights, surface.vertices[corners])
    start = corners[np.arange(len(rows)), weights.argmax(axis=1)]
    return placed(images, start, surface)


def _inverted(placement: Placement, faces: IntArray) -> bool:
    """Return whether most of the registered surface is wound the other way round."""
    normals = face_normals(placement.positions, faces)
    return bool((normals * placement.normals[faces].sum(axis=1)).sum() < 0.0)


def _least_qualities(template: TriangleMesh) -> FloatArray:
    """(F,) qualities below which triangles are relaxed: less for those that are bad at rest."""
    rest = Placement(*_of_unit_area(template), np.arange(template.n_vertices))
    found = corner_qualities(rest, template.faces)
    least: FloatArray = np.minimum(_BAD, np.where(found > 0.0, 0.5, 2.0) * found)
    return least


def _centre(mesh: TriangleMesh) -> FloatArray:
    centre: FloatArray = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    return centre
