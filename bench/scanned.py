"""Generated shapes with the defects of scans: textured, noisy, with holes, remeshed.

Like those of INRIA Grenoble in section 6.3, they have topological noise and irregular
triangulations; besides, noise along the normals, noisy colours, and light of another strength and
tint in each.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, islice

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, simplified, triangle_mesh, vertex_normals
from solver.registration.surface import MIRROR
from solver.shape import Shape
from synthetic import (
    CLASSES,
    SyntheticShape,
    Transformed,
    articulated,
    clothed,
    glued,
    near_in_space,
    noisy,
    with_holes,
)

GLUED, APART = 2, 0.6
"""Places that are glued, of all so far from one another along the surface, per √area."""
HOLES, HOLE_RADIUS = 3, 0.03
"""Holes, and their radius per √area."""
NOISE_EDGES = 0.15
"""Standard deviation along the normals, in mean lengths of edges."""
LEFT = 0.6
"""Share of the vertices that is left when flat parts are made coarse."""
COLOR_NOISE = 0.05
"""Standard deviation of each channel at each vertex."""


@dataclass(frozen=True)
class Light:
    """Lighting of a scan.

    Attributes
    ----------
    tint
        How much each channel is brighter or darker at most, in each shape otherwise.
    shade
        How much darker it is on the side without light.
    """

    tint: float
    shade: float


SAME, OTHER, HARD = Light(0.0, 0.0), Light(0.1, 0.15), Light(0.15, 0.3)
"""That of Table 1, which is uniform; and lights that differ from scan to scan."""


@dataclass(frozen=True, eq=False)
class ScannedShape:
    """A figure in a pose, and what a scan makes of it.

    Parameters
    ----------
    name, category
        The class is one of :data:`synthetic.CLASSES`.
    shape
        The scan, which is matched; without colours until it is lit.
    rest
        (V, 3) where its vertices are on the figure at rest.
    clean
        The figure without faults, on which errors are measured: glued places shorten none.
    clean_rest
        The same for the clean figure's vertices.
    glued
        Whether the scan is glued to itself.
    """

    name: str
    category: str
    shape: Shape
    rest: FloatArray
    clean: Shape
    clean_rest: FloatArray
    glued: bool


def scanned_shapes(resolution: int, classes: int) -> Iterator[ScannedShape]:
    """Four poses of each of the first classes, every one triangulated on its own.

    Parameters
    ----------
    resolution
        Vertices of the figures, of which `LEFT` are left.
    classes
        How many classes.

    Yields
    ------
    shape
        Every other one is glued.
    """
    for category, known in islice(CLASSES.items(), classes):
        for number, pose in enumerate(islice(known.poses, 4)):
            figure = articulated(category, pose, resolution, seed=number)
            yield _scanned(f"{category}{number}-{pose}", category, figure, number)


def lit(scan: ScannedShape, light: Light) -> ScannedShape:
    """The same scan in a light of its own, from one side, with noise in its colours."""
    mesh = scan.shape.mesh
    rng = np.random.default_rng(list(scan.name.encode()))
    direction = rng.standard_normal(3)
    facing = vertex_normals(mesh.vertices, mesh.faces) @ (direction / np.linalg.norm(direction))
    shade = 1.0 - light.shade * 0.5 * (1.0 - facing)
    tint = rng.uniform(1.0 - light.tint, 1.0 + light.tint, 3)
    noise = COLOR_NOISE * rng.standard_normal((mesh.n_vertices, 3))
    colors = clothed(scan.rest) * shade[:, None] * tint + noise
    seen = replace(mesh, colors=colors.clip(0.0, 1.0))
    return replace(scan, shape=Shape(seen, spectrum=scan.shape.spectrum()))


def scanned_pairs(shapes: list[ScannedShape]) -> list[tuple[ScannedShape, ScannedShape]]:
    """All pairs of a class of which one is glued and the other is not, in either order."""
    pairs = [(a, b) for a, b in combinations(shapes, 2) if a.category == b.category]
    return [(a, b) for a, b in pairs if a.glued != b.glued]


def point_errors(
    source: ScannedShape, target: ScannedShape, here: IntArray, there: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Geodesic errors over √area of matched points, direct and under the left-right symmetry.

    Parameters
    ----------
    source, target
        Of one class.
    here, there
        (n,) vertices of either.
    """
    tree = KDTree(target.clean_rest)
    found = np.asarray(tree.query(target.rest[there])[1], dtype=np.int64)
    distances = target.clean.metric("geodesic").distances(found) / target.clean.size
    rows = np.arange(len(found))
    truths = (tree.query(source.rest[here] * turn)[1] for turn in (1.0, MIRROR))
    direct, mirrored = (distances[rows, np.asarray(truth)] for truth in truths)
    return direct, mirrored


def _scanned(name: str, category: str, figure: SyntheticShape, number: int) -> ScannedShape:
    clean = triangle_mesh(figure.vertices, figure.faces)
    size = float(np.sqrt(clean.area))
    mesh, rest = clean, figure.rest
    glue = number % 2 == 1
    if glue:
        mesh, rest = _after(glued(mesh, near_in_space(mesh, GLUED, APART * size)), rest)
    mesh, rest = _after(with_holes(mesh, HOLES, HOLE_RADIUS * size, number), rest)
    mesh, rest = _after(noisy(mesh, NOISE_EDGES, number), rest)
    coarse = simplified(mesh, round(LEFT * mesh.n_vertices))
    rest = rest[mesh.vertices_of(coarse.vertex_ids)]
    return ScannedShape(name, category, Shape(coarse), rest, Shape(clean), figure.rest, glue)


def _after(transformed: Transformed, rest: FloatArray) -> tuple[TriangleMesh, FloatArray]:
    """The mesh, and where its vertices are at rest."""
    moved = np.empty((transformed.mesh.n_vertices, 3))
    kept = np.flatnonzero(transformed.kept)
    moved[transformed.image[kept]] = rest[kept]
    return transformed.mesh, moved
