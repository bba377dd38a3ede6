"""Parts of surfaces: discs of many sizes cut out of a body, until a share of its area is gone."""

from dataclasses import dataclass

import numpy as np

from bench.collection import KnownShape
from bench.humans import USUAL, random_pose, random_proportions
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, components_of, triangle_areas, triangle_mesh
from solver.shape import Shape
from synthetic import human_figure, submesh
from synthetic.shapes import correspondence, posed

VERTICES = 2000, 4000


@dataclass(frozen=True)
class Cut:
    """How much is cut out.

    Parameters
    ----------
    shares
        Range of the share of the area that is gone.
    radii
        Range of the radii of discs, over √area.
    """

    shares: tuple[float, float]
    radii: tuple[float, float]


CUTS = {
    "few large holes": Cut((0.2, 0.4), (0.15, 0.45)),
    "many small holes": Cut((0.35, 0.5), (0.06, 0.16)),
}

HALF = "half"
"""What lies on one side of a plane."""

_HALVES = 0.6, 0.75
"""Share of the vertices on the side of a plane that is kept."""

_TOO_MUCH = 0.1
"""Share of the area by which the range may be exceeded; discs that take more are not cut."""


def generated_part(
    seed: int, vertices: tuple[int, int] = VERTICES
) -> tuple[str, KnownShape, KnownShape]:
    """Return the kind of cut, a part of one person, and another person in another pose.

    Parameters
    ----------
    seed
        Chooses all three.
    vertices
        Range of the numbers of vertices of both bodies.
    """
    rng = np.random.default_rng(seed)
    kind = list(CUTS)[seed % len(CUTS)]
    ours, theirs = (
        posed(
            human_figure(random_proportions(USUAL, rng)),
            random_pose(rng),
            int(rng.integers(*vertices)),
            int(rng.integers(1000)),
        )
        for _ in range(2)
    )
    mesh = triangle_mesh(ours.vertices, ours.faces)
    kept, part = cut(mesh, CUTS[kind], rng)
    scale = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
    shape = Shape(part.scaled(scale))
    truth = correspondence(ours, theirs)[kept]
    there = Shape(triangle_mesh(theirs.vertices, theirs.faces))
    return (
        kind,
        KnownShape(f"part{seed}", "part", shape, np.arange(len(kept)), None),
        KnownShape(f"whole{seed}", "part", there, truth, None),
    )


def cut_out(whole: KnownShape, kind: str, rng: np.random.Generator) -> KnownShape:
    """Return a part of a shape; points that it lacks are -1 in its truth.

    Parameters
    ----------
    whole
        A shape with known truth.
    kind
        One of `CUTS`, or `HALF`.
    rng
        Chooses what is cut.
    """
    mesh = whole.shape.surface
    vertices, part = half(mesh, mesh.vertices, rng) if kind == HALF else cut(mesh, CUTS[kind], rng)
    return known_part(whole, kind, vertices, part)


def known_part(whole: KnownShape, kind: str, vertices: IntArray, part: TriangleMesh) -> KnownShape:
    """Return a part of a shape; points that it lacks are -1 in its truth.

    Parameters
    ----------
    whole
        A shape with known truth.
    kind
        Named after the shape's name.
    vertices, part
        (n,) vertices of the shape's surface that remain, and the mesh of these.
    """
    assert whole.truth is not None
    numbers = np.full(whole.shape.n_vertices, -1)
    numbers[vertices] = part.vertices_of(np.arange(len(vertices)))
    name = f"{whole.name} {kind}"
    return KnownShape(name, whole.category, Shape(part), numbers[whole.truth], None)


def half(
    mesh: TriangleMesh, places: FloatArray, rng: np.random.Generator
) -> tuple[IntArray, TriangleMesh]:
    """Keep what lies on one side of a plane through a body: its front, its left, ...

    Parameters
    ----------
    mesh
        V vertices.
    places
        (V, 3) where they are, or where they are at rest.
    rng
        Chooses the plane.
    """
    heights: FloatArray = places @ rng.normal(size=3)
    kept = np.asarray(heights > np.quantile(heights, 1.0 - rng.uniform(*_HALVES)))
    return largest_piece(mesh, kept)


def largest_piece(mesh: TriangleMesh, kept: BoolArray) -> tuple[IntArray, TriangleMesh]:
    """Return the largest component of the faces all of whose (V,) vertices are kept.

    Returns
    -------
    vertices : (n,) its vertices.
    part : the mesh of these.
    """
    return submesh(mesh, largest_component(mesh, np.asarray(kept[mesh.faces].all(axis=1))))


def cut(mesh: TriangleMesh, how: Cut, rng: np.random.Generator) -> tuple[IntArray, TriangleMesh]:
    """Cut geodesic discs out of a mesh; the largest component remains.

    Parameters
    ----------
    mesh
        A connected mesh.
    how
        What is cut.
    rng
        Chooses the discs.

    Returns
    -------
    vertices : (n,) vertices of the mesh that remain.
    part : the mesh of these.
    """
    metric = Shape(mesh).metric("geodesic")
    areas = triangle_areas(mesh.vertices, mesh.faces)
    areas = areas / areas.sum()
    gone = float(rng.uniform(*how.shares))
    kept = np.ones(mesh.n_faces, dtype=np.bool_)
    while areas[kept].sum() > 1.0 - gone:
        distances = metric.distances(np.array([rng.integers(mesh.n_vertices)]))[0]
        inside = distances[mesh.faces] < rng.uniform(*how.radii)
        further = largest_component(mesh, kept & ~inside.all(axis=1))
        if areas[further].sum() > 1.0 - gone - _TOO_MUCH:
            kept = further
    return submesh(mesh, kept)


def largest_component(mesh: TriangleMesh, kept: BoolArray) -> BoolArray:
    """(F,) faces of the largest component of those kept."""
    faces = mesh.faces[kept]
    components = components_of(np.concatenate([faces[:, :2], faces[:, 1:]]), mesh.n_vertices)
    of_faces = components[mesh.faces[:, 0]]
    found: BoolArray = kept & (of_faces == np.bincount(of_faces[kept]).argmax())
    return found
