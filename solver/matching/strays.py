"""Stray components: parts of a scan, such as the floor, that the other shape does not have.

Bodies may come in pieces, so components are linked and matched as one surface. The shapes fit far
better without a component that the other shape does not have.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from solver.arrays import BoolArray, IntArray
from solver.control import Control
from solver.matching.landmarks import landmark_vertices
from solver.mesh import TriangleMesh, component_areas, of_components
from solver.mesh.repair import counted
from solver.registration import STAGE, first_score
from solver.registration.reduction import reduction
from solver.shape import Shape

_LEAST_SHARE = 0.02
"""Share of the area from which a component is looked at by itself, and all smaller ones together:
less hardly changes where the others go."""

_MOST = 4
"""Components of a shape that are looked at by themselves, the largest."""

_MARGIN = 1.0
"""How much less the score has to be for each that is left out. Without balls, floors and debris
beside people it is 0.7 to 5 less; of 40 pieces of bodies it is 0.4 less without two, and more
without the others."""

Shapes = tuple[Shape, Shape]
Kept = tuple[BoolArray, BoolArray]
Loose = tuple[list[IntArray], list[IntArray]]


def without_strays(
    source: Shape, target: Shape, landmarks: tuple[tuple[int, int], ...], control: Control
) -> Shapes:
    """Leave out components of either shape that the other shape does not have.

    They are left out one after the other, as long as the shapes fit far better without. If a
    component that both have, such as the jaw of a skull, has moved, the shapes fit better without
    it, too. Where the answer is sure, components of both shapes are therefore never left out
    together.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    landmarks
        Pairs of the user's own vertex numbers; components with one are kept.
    control
        Cancels; past its deadline, nothing more is tried.

    Returns
    -------
    The same shapes, or what is left of them, with a warning each; vertices of what is left out
    have no image, as those of debris.

    Raises
    ------
    Cancelled
        Through `control`.
    OptionError
        A landmark is not on its mesh.
    """
    shapes = source, target
    loose = _loose(shapes, landmarks)
    if not any(loose):
        return shapes
    with control.stage(STAGE):
        reduced = _Reduced(shapes)
        found, best = _tried(reduced, _every(shapes), control), None
        while found is not best:
            best = found
            trials = [
                _tried(reduced, kept, control, best.left_out + count)
                for kept, count in control.in_time(_fewer(best.kept, loose))
                if count == 1 or not best.is_sure
            ]
            found = min([best, *trials], key=lambda one: one.score)
    return _left(shapes, found.kept)


def largest_components(
    source: Shape, target: Shape, landmarks: tuple[tuple[int, int], ...]
) -> Shapes:
    """Leave out all components but the largest of each shape, and those with landmarks.

    Parameters
    ----------
    source, target, landmarks
        As for :func:`without_strays`.

    Returns
    -------
    The same shapes, or what is left of them, with a warning each.

    Raises
    ------
    OptionError
        A landmark is not on its mesh.
    """
    shapes = source, target
    kept = _every(shapes)
    pairs = landmark_vertices(landmarks, source.mesh, target.mesh).T
    for one, known, ends in zip(shapes, kept, pairs, strict=True):
        component = one.mesh.component_of_vertex
        known[:] = False
        known[[component_areas(one.mesh).argmax(), *component[ends]]] = True
    return _left(shapes, kept)


@dataclass(frozen=True, eq=False)
class _Trial:
    """A first registration of some components of both shapes.

    Parameters
    ----------
    kept
        (C,) components of X and of Y that are kept.
    left_out
        How many times some were left out.
    score
        Of the fit, and the margin for each time; infinite for what cannot be registered.
    is_sure
        Whether the answer is.
    """

    kept: Kept
    left_out: int
    score: float
    is_sure: bool


def _tried(reduced: "_Reduced", kept: Kept, control: Control, left_out: int = 0) -> _Trial:
    """Register some components of both shapes, reduced."""
    score, is_sure = reduced.score(kept, control)
    return _Trial(kept, left_out, score + _MARGIN * left_out, is_sure)


def _every(shapes: Shapes) -> Kept:
    source, target = (np.ones(one.mesh.components, dtype=np.bool_) for one in shapes)
    return source, target


def _loose(shapes: Shapes, landmarks: tuple[tuple[int, int], ...]) -> Loose:
    """Components of both shapes that may be left out."""
    source, target = (one.mesh for one in shapes)
    ours, theirs = landmark_vertices(landmarks, source, target).T
    return _loose_of(source, ours), _loose_of(target, theirs)


def _loose_of(mesh: TriangleMesh, landmarks: IntArray) -> list[IntArray]:
    """Components of one shape that may be left out, all small ones together, the smallest first."""
    if mesh.components == 1:
        return []
    shares = component_areas(mesh) / mesh.area
    ascending = np.argsort(shares, kind="stable")
    first_large = int(np.searchsorted(shares[ascending], _LEAST_SHARE))
    small, large = ascending[:first_large], ascending[first_large:][-_MOST:]
    found = [] if shares[small].sum() < _LEAST_SHARE else [small]
    if len(large) > 1:
        found += np.split(large, len(large))
    held = mesh.component_of_vertex[landmarks]
    return [one for one in found if not np.isin(one, held).any()]


def _fewer(kept: Kept, loose: Loose) -> Iterator[tuple[Kept, int]]:
    """Leave more of one shape out, or of each, but never all; and of how many shapes."""
    nothing = np.zeros(0, dtype=np.int64)
    here, there = (
        [nothing, *(one for one in many if known[one].any())]
        for known, many in zip(kept, loose, strict=True)
    )
    for out in sorted(product(here, there), key=_shapes_of)[1:]:
        fewer = kept[0].copy(), kept[1].copy()
        for known, numbers in zip(fewer, out, strict=True):
            known[numbers] = False
        if all(known.any() for known in fewer):
            yield fewer, _shapes_of(out)


def _shapes_of(out: tuple[IntArray, IntArray]) -> int:
    """Of how many shapes something is left out."""
    return sum(len(one) > 0 for one in out)


@dataclass(frozen=True, eq=False)
class _Reduced:
    """What is kept of both shapes, reduced; each with its spectrum, and registered, once.

    Parameters
    ----------
    shapes
        The shapes X and Y.
    """

    shapes: Shapes
    _known: dict[tuple[int, bytes], Shape] = field(default_factory=dict, init=False, repr=False)
    _scores: dict[tuple[bytes, bytes], tuple[float, bool]] = field(
        default_factory=dict, init=False, repr=False
    )

    def score(self, kept: Kept, control: Control) -> tuple[float, bool]:
        """Return the score of a registration of what is kept, and whether the answer is sure."""
        source, target = kept
        key = source.tobytes(), target.tobytes()
        if key not in self._scores:
            self._scores[key] = first_score(self._of(0, source), self._of(1, target), control)
        return self._scores[key]

    def _of(self, number: int, kept: BoolArray) -> Shape:
        key = number, kept.tobytes()
        if key not in self._known:
            self._known[key] = _reduced(self.shapes[number], kept)
        return self._known[key]


def _reduced(shape: Shape, kept: BoolArray) -> Shape:
    """Return what is kept of a shape, reduced."""
    fewer = reduction(shape)
    if kept.all():
        return fewer.shape
    mesh = fewer.shape.mesh
    original = np.empty(mesh.components, dtype=np.int64)
    original[mesh.component_of_vertex] = shape.mesh.component_of_vertex[fewer.vertices]
    return shape.with_mesh(of_components(mesh, kept[original], ""))


def _left(shapes: Shapes, kept: Kept) -> Shapes:
    source, target = (_left_of(*one) for one in zip(shapes, kept, strict=True))
    return source, target


def _left_of(shape: Shape, kept: BoolArray) -> Shape:
    """Return what is kept of a shape, with a warning that says what is left out."""
    if kept.all():
        return shape
    mesh, out = shape.mesh, ~kept
    areas = component_areas(mesh)
    share = 100.0 * areas[out].sum() / areas.sum()
    vertices = counted(int(out[mesh.component_of_vertex].sum()), "vertex", "vertices")
    note = (
        f"left out {counted(int(out.sum()), 'component')} of {vertices}, {share:.3g} % of the area:"
        " without, the shapes fit far better; `partial: none` keeps all"
    )
    return shape.with_mesh(of_components(mesh, kept, note))
