"""Pairs of a shape and its transformation, for the experiment on invariance."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
from scipy.spatial import KDTree

from bench.collection import KnownShape, Pair
from bench.symmetry import mirrored_vertices
from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import Shape
from synthetic import (
    CLASSES,
    Transformed,
    articulated,
    glued,
    near_in_space,
    noisy,
    painted,
    remeshed,
    scaled,
    with_holes,
)

BENDING, TOPOLOGY, HOLES, SCALE, NOISE, REMESHING = TRANSFORMATIONS = (
    "bending",
    "topology",
    "holes",
    "scale",
    "noise",
    "remeshing",
)

GLUED_PAIRS = 2
"""Pairs of places that are glued: those nearest in space, of all that are `APART`."""
APART = 0.6
"""Least distance along the surface of what is glued, per √area."""
HOLE_COUNT, HOLE_RADIUS = 5, 0.03
"""Holes, and their radius per √area."""
FACTOR = 2.0
"""Of the change of scale."""
NOISE_EDGES = 0.2
"""Standard deviation of the noise along the normals, in mean lengths of edges."""
REMESHED_SHARE = 0.8
"""Vertices of the new triangulation per vertex of the old one."""


def generated_pairs(resolution: int, classes: int) -> Iterator[tuple[str, Pair]]:
    """Figures of the first classes: bent, with the triangulation kept, and transformed.

    Parameters
    ----------
    resolution
        Vertices of each shape.
    classes
        How many of :data:`synthetic.CLASSES`.

    Yields
    ------
    transformation, pair
        The shapes are not normalised; the first one has unit area.
    """
    for category, known in islice(CLASSES.items(), classes):
        figures = [articulated(category, pose, resolution) for pose in known.poses]
        rest = figures[0].rest
        meshes = [triangle_mesh(f.vertices, f.faces, painted(rest)) for f in figures]
        unit = 1.0 / np.sqrt(meshes[0].area)
        poses = [replace(mesh, vertices=unit * mesh.vertices) for mesh in meshes]
        every = np.arange(len(rest))
        mirrored = mirrored_vertices(rest)
        null = _known(category, poses[0], every, mirrored)
        for mesh in poses[1:]:
            yield BENDING, (null, _known(category, mesh, every, mirrored))
        yield from transformed_pairs(null)


def real_pairs(shapes: list[KnownShape]) -> Iterator[tuple[str, Pair]]:
    """The first shape of every class: beside the others, and transformed.

    Parameters
    ----------
    shapes
        A collection with ground truth. Colours, which it has not, are painted on.

    Yields
    ------
    transformation, pair
        As by :func:`generated_pairs`, but bent shapes have triangulations of their own.
    """
    by_class: dict[str, list[KnownShape]] = {}
    for shape in shapes:
        if shape.truth is not None:
            by_class.setdefault(shape.category, []).append(shape)
    for category, members in by_class.items():
        first = members[0].shape.mesh
        unit = 1.0 / np.sqrt(first.area)
        truth = members[0].truth
        assert truth is not None
        paint = painted(1.75 * unit * (first.vertices[truth] - first.vertices.mean(axis=0)))
        known = []
        for member in members:
            own, symmetric = member.truth, member.symmetric_truth
            assert own is not None
            mesh = member.shape.mesh
            nearest = KDTree(mesh.vertices[own]).query(mesh.vertices)[1]
            mesh = replace(mesh, vertices=unit * mesh.vertices, colors=paint[nearest])
            known.append(_known(category, mesh, own, own if symmetric is None else symmetric))
        for other in known[1:]:
            yield BENDING, (known[0], other)
        yield from transformed_pairs(known[0])


def passage_pairs(resolution: int) -> Iterator[tuple[str, Pair]]:
    """A human with its hands glued to its legs, by passages of growing width.

    Yields
    ------
    radius, pair
        The radius of the discs that are glued, over √area, in words.
    """
    figure = articulated("human", "standing", resolution)
    mesh = triangle_mesh(figure.vertices, figure.faces, painted(figure.rest))
    mesh = replace(mesh, vertices=mesh.vertices / np.sqrt(mesh.area))
    every = np.arange(mesh.n_vertices)
    null = _known("human", mesh, every, every)
    places = near_in_space(mesh, GLUED_PAIRS, APART)
    for name, radius in {"a face": None, "faces around": 0.0, "0.02": 0.02, "0.04": 0.04}.items():
        yield name, _pair(null, glued(mesh, places, radius))


def transformed_pairs(null: KnownShape) -> Iterator[tuple[str, Pair]]:
    """A shape of unit area, and it transformed in every way but bent.

    Parameters
    ----------
    null
        Closed and oriented, with colours, a truth and a symmetric truth.
    """
    mesh = null.shape.mesh
    transformations: dict[str, Transformed] = {
        TOPOLOGY: glued(mesh, near_in_space(mesh, GLUED_PAIRS, APART)),
        HOLES: with_holes(mesh, HOLE_COUNT, HOLE_RADIUS),
        SCALE: scaled(mesh, FACTOR),
        NOISE: noisy(mesh, NOISE_EDGES),
        REMESHING: _repainted(mesh, remeshed(mesh, round(REMESHED_SHARE * mesh.n_vertices))),
    }
    for name, transformed in transformations.items():
        yield name, _pair(null, transformed)


def _pair(null: KnownShape, transformed: Transformed) -> Pair:
    """The points whose places are still there, and where they are."""
    assert null.truth is not None
    assert null.symmetric_truth is not None
    left = transformed.kept[null.truth] & transformed.kept[null.symmetric_truth]
    here, mirrored = null.truth[left], null.symmetric_truth[left]
    source = KnownShape(null.name, null.category, null.shape, here, mirrored)
    image = transformed.image
    return source, _known(null.category, transformed.mesh, image[here], image[mirrored])


def _known(
    category: str, mesh: TriangleMesh, truth: IntArray, symmetric_truth: IntArray
) -> KnownShape:
    shape = Shape(mesh, normalise=False)
    return KnownShape(category, category, shape, truth, symmetric_truth)


def _repainted(old: TriangleMesh, transformed: Transformed) -> Transformed:
    """The new triangulation with the colours of the nearest of the old vertices."""
    nearest = KDTree(old.vertices).query(transformed.mesh.vertices)[1]
    assert old.colors is not None
    colors: FloatArray = old.colors[nearest]
    return replace(transformed, mesh=replace(transformed.mesh, colors=colors))
