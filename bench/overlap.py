"""Pairs of surfaces that overlap, neither a part of the other: two bodies, each cut on its own."""

from collections.abc import Callable

import numpy as np
from scipy.spatial import KDTree

from bench.collection import KnownShape
from bench.conditions import CONDITIONS, scanned
from bench.cut import VERTICES, Cut, cut, half, known_part, largest_piece
from bench.humans import USUAL, random_pose, random_proportions
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import Shape
from synthetic import human_figure, transferred
from synthetic.shapes import posed

OVERLAPS, OVERLAPS_OF_SIDES = (0.5, 0.9), (0.3, 0.9)
"""Ranges of the shares of the vertices of both that have a partner."""

SIDES = 0.12, 0.35
"""Range of the share of the vertices of either that is missing, of opposite sides."""

NEAR = 0.02
"""Distance in space over √area from a true partner within which a vertex has one."""

_ENDS = "three ends cut off"

CutOf = Callable[[TriangleMesh, FloatArray, np.random.Generator], tuple[IntArray, TriangleMesh]]


def _discs(how: Cut) -> CutOf:
    return lambda mesh, _, rng: cut(mesh, how, rng)


KINDS: dict[str, CutOf] = {
    "halves": half,
    "few large holes": _discs(Cut((0.2, 0.4), (0.15, 0.45))),
    "many small holes": _discs(Cut((0.2, 0.35), (0.06, 0.16))),
}


def _side(axis: int, sign: float) -> CutOf:
    """Cut a side off: the left or the right, above or below, the front or the back."""

    def cut_off(
        mesh: TriangleMesh, rest: FloatArray, rng: np.random.Generator
    ) -> tuple[IntArray, TriangleMesh]:
        places = sign * rest[:, axis]
        return largest_piece(mesh, np.asarray(places > np.quantile(places, rng.uniform(*SIDES))))

    return cut_off


OPPOSITE: dict[str, tuple[CutOf, CutOf]] = {
    name: (_side(axis, 1.0), _side(axis, -1.0))
    for axis, name in enumerate(("left and right", "above and below", "front and back"))
}


def generated_overlap(seed: int, opposite: bool = False) -> tuple[str, KnownShape, KnownShape]:
    """Return the kind of cut, and two surfaces that overlap, in other poses.

    They are of one person for even seeds, of two for odd ones. Cuts are drawn again if they leave
    more or less in common than `OVERLAPS`.

    Parameters
    ----------
    seed
        Of bodies, poses and cuts.
    opposite
        Whether they lack opposite sides, with `OVERLAPS_OF_SIDES` in common.
    """
    rng = np.random.default_rng(seed)
    kinds = OPPOSITE if opposite else {name: (cut_off,) * 2 for name, cut_off in KINDS.items()}
    least, most = OVERLAPS_OF_SIDES if opposite else OVERLAPS
    kind = list(kinds)[seed % 3 if opposite else seed // 2 % 3]
    figure = human_figure(random_proportions(USUAL, rng))
    other = human_figure(random_proportions(USUAL, rng)) if seed % 2 else figure
    bodies = [
        posed(one, random_pose(rng), int(rng.integers(*VERTICES)), int(rng.integers(1000)))
        for one in (figure, other)
    ]
    places = transferred(bodies[0].rest, figure, other)
    partners: IntArray = np.asarray(KDTree(bodies[1].rest).query(places)[1], dtype=np.int64)
    truth = np.arange(len(partners)), partners
    while True:
        shapes = []
        names = "source", "target"
        for name, cut_off, body, points in zip(names, kinds[kind], bodies, truth, strict=True):
            mesh = triangle_mesh(body.vertices, body.faces)
            vertices, part = cut_off(mesh, body.rest, rng)
            numbers = np.full(mesh.n_vertices, -1)
            numbers[vertices] = np.arange(len(vertices))
            scale = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
            shape = Shape(part.scaled(scale))
            shapes.append(KnownShape(f"{name}{seed}", "overlap", shape, numbers[points], None))
        source, target = shapes
        shares = truly_covered(source, target).mean(), truly_covered(target, source).mean()
        if least <= min(shares) and max(shares) <= most:
            return kind, source, target


def without_ends(whole: KnownShape) -> KnownShape:
    """Return a shape without the ends of three limbs; points that it lacks are -1 in its truth."""
    part = scanned(whole.shape.surface, CONDITIONS[_ENDS]).mesh
    return known_part(whole, _ENDS, part.vertex_ids, part)


def truly_covered(shape: KnownShape, other: KnownShape) -> BoolArray:
    """(V,) vertices of a shape that have a partner on another one.

    Parameters
    ----------
    shape, other
        Shapes of one class, both with known truth; -1 stands for a point that a shape lacks.
    """
    assert shape.truth is not None
    assert other.truth is not None
    positions = shape.shape.surface.vertices
    partners = shape.truth[(other.truth >= 0) & (shape.truth >= 0)]
    apart, _ = KDTree(positions[partners]).query(positions)
    return np.asarray(apart < NEAR * shape.shape.size)
