"""Surfaces opened where parts of them touch.

Where parts of a body touch, scanners glue them together: paths lead from a hand to a thigh, and no
smooth function tells the two apart. So the triangles in between are taken out. Two things tell
which these are. Before any map is known, *creases*: the surface is folded inwards where two parts
meet. And under a map that is nearly right, *tears*: neighbours on a glued surface have images that
are far apart.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, components_of, triangle_areas
from solver.registration.confidence import RIGHT_ERROR
from solver.registration.surface import SmoothSurface, smooth_surface
from solver.shape import Shape
from solver.shape.laplacian import definite_factor

_CUT = 0.05
"""By how much the images of neighbours are farther apart, in √area, where a tear cuts a piece off.
Few errors do that, so that less counts than at other tears: pieces on the limb beside their own are
found with 0.03 to 0.06."""

_LEAST_TORN = 0.4
"""Length over √area below which tears are nothing but errors of a map: 0.003 of the triangles of
meshes of some 9,000 vertices, for which it was chosen."""

_LEAST_PART = 0.02
"""Share of the area below which a component that was cut off is left out."""

_LEAST_LEFT = 0.75
"""Share of the area that has to be left: a surface with more creases is rough rather than glued,
and a map that tears more of it is none."""


@dataclass(frozen=True)
class Crease:
    """What counts as a crease.

    Parameters
    ----------
    width
        Width over which the surface is smoothed, in √area: an edge of a mesh of some 3,000 vertices
        is 0.02 long, of 12,000 0.01.
    folded
        Sine of half the angle by which the normals turn: 0.3, 0.2 and 0.1 are 35°, 23° and 11°.
    """

    width: float
    folded: float


CREASES = Crease(0.02, 0.3), Crease(0.01, 0.2), Crease(0.01, 0.1)
"""From few and wide creases to many and slight ones. None is the best for all: on the shapes of
TOPKIDS, the first take out 2 to 6 % of the area, and of what is glued a twentieth to a quarter; the
last 9 to 16 %, folds of the body among them, and of what is glued a quarter to two thirds."""


@dataclass(frozen=True, eq=False)
class Opening:
    """A shape without some of its triangles.

    Parameters
    ----------
    shape
        What is left of the whole shape.
    vertices
        (K,) its vertices, in the numbers of the whole shape.
    index_of_vertex
        (V,) index of each vertex of the whole shape among these; of one that is left out, that of
        the nearest in space.
    faces
        (F,) its triangles, in the numbers of the whole shape.
    """

    shape: Shape
    vertices: IntArray
    index_of_vertex: IntArray
    faces: IntArray

    @classmethod
    def nowhere(cls, shape: Shape) -> "Opening":
        """Return the whole shape."""
        every = np.arange(shape.n_vertices)
        return cls(shape, every, every, np.arange(shape.mesh.n_faces))

    @classmethod
    def at(cls, shape: Shape, out: BoolArray) -> "Opening":
        """Take triangles out of a shape, and components that are then too small to matter.

        Parameters
        ----------
        shape
            The whole shape.
        out
            (F,) whether a triangle is taken out. None is if too little would be left.
        """
        whole = shape.mesh
        if not out.any() or out.all():
            return cls.nowhere(shape)
        faces = np.flatnonzero(~out)
        vertices, corners = _compact(whole.faces[faces])
        kept = _part(whole, vertices, corners)
        areas = triangle_areas(kept.vertices, corners)
        component = kept.component_of_vertex[corners[:, 0]]
        share = np.bincount(component, areas) / areas.sum()
        if areas[share[component] >= _LEAST_PART].sum() < _LEAST_LEFT * whole.area:
            return cls.nowhere(shape)
        if (share < _LEAST_PART).any():
            faces = faces[share[component] >= _LEAST_PART]
            vertices, corners = _compact(whole.faces[faces])
            kept = _part(whole, vertices, corners)
        index = np.full(whole.n_vertices, -1)
        index[vertices] = np.arange(len(vertices))
        left_out = np.flatnonzero(index < 0)
        index[left_out] = KDTree(kept.vertices).query(whole.vertices[left_out])[1]
        return cls(shape.with_mesh(kept), vertices, index, faces)


def _part(whole: TriangleMesh, vertices: IntArray, corners: IntArray) -> TriangleMesh:
    colors = None if whole.colors is None else whole.colors[vertices]
    return TriangleMesh(whole.vertices[vertices], corners, vertices, colors)


def _compact(faces: IntArray) -> tuple[IntArray, IntArray]:
    """(K,) the vertices of some faces, and (F, 3) the faces as indices of these."""
    vertices, corners = np.unique(faces, return_inverse=True)
    return vertices, corners.reshape(-1, 3)


def creases(surface: SmoothSurface, crease: Crease) -> BoolArray:
    """(F,) whether a triangle lies where the surface is folded inwards.

    With x smoothed over the width r, y − r² Δy = x, the middle of a straight crease between two
    planes whose normals differ by the angle α moves outwards by r sin(α / 2).

    Parameters
    ----------
    surface
        Of unit area.
    crease
        What counts as one.
    """
    mesh = surface.mesh
    stiffness, mass = surface.laplacian
    smoothing = definite_factor(sp.csc_array(sp.diags_array(mass) + crease.width**2 * stiffness))
    fields = np.hstack([mesh.vertices, surface.normals])
    smoothed = np.asarray(smoothing.solve(mass[:, None] * fields))
    normals = smoothed[:, 3:] / np.maximum(
        np.linalg.norm(smoothed[:, 3:], axis=1, keepdims=True), 1e-12
    )
    outwards = ((smoothed[:, :3] - mesh.vertices) * normals).sum(axis=1)
    folded: BoolArray = (outwards > crease.folded * crease.width)[mesh.faces].any(axis=1)
    return folded


def tears(mesh: TriangleMesh, images: FloatArray) -> BoolArray:
    """(F,) whether the images of a triangle's vertices are much farther apart than these.

    That is by more than the error of a right answer.

    Parameters
    ----------
    mesh
        The surface, of unit area.
    images
        (V, 3) images of its vertices on another, of unit area, too.
    """
    before, after = (
        np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        for corners in (mesh.vertices[mesh.faces], images[mesh.faces])
    )
    torn: BoolArray = (after > before + RIGHT_ERROR).any(axis=1)
    return torn


def torn_length(mesh: TriangleMesh, torn: BoolArray) -> float:
    """Length of tears over √area: sum of the square roots of the areas of torn triangles.

    A tear is a line, so that its share of the triangles falls as these become smaller.

    Parameters
    ----------
    mesh
        F triangles.
    torn
        (F,) which are torn.
    """
    areas = triangle_areas(mesh.vertices, mesh.faces)
    return float(np.sqrt(areas[torn] / areas.sum()).sum())


def torn_off(mesh: TriangleMesh, images: FloatArray) -> BoolArray:
    """(V,) whether tears cut a vertex off the largest piece of its component.

    Parameters
    ----------
    mesh, images
        As for :func:`tears`.
    """
    before, after = (
        np.linalg.norm(np.diff(positions[mesh.edges], axis=1)[:, 0], axis=1)
        for positions in (mesh.vertices, images)
    )
    piece = components_of(mesh.edges[after <= before + _CUT], mesh.n_vertices)
    size = np.bincount(piece)[piece]
    largest = np.zeros(mesh.components, dtype=np.int64)
    np.maximum.at(largest, mesh.component_of_vertex, size)
    off: BoolArray = size < largest[mesh.component_of_vertex]
    return off


@dataclass(frozen=True, eq=False)
class VertexMaps:
    """Maps between all vertices of two whole shapes.

    Parameters
    ----------
    images
        (V,) target vertices.
    back
        (W,) source vertices.
    """

    images: IntArray
    back: IntArray

    def openings(self, source: Shape, target: Shape) -> tuple[Opening, Opening]:
        """Open both shapes where they are torn."""
        ours, theirs = smooth_surface(source).mesh, smooth_surface(target).mesh
        return (
            _torn_open(source, tears(ours, theirs.vertices[self.images])),
            _torn_open(target, tears(theirs, ours.vertices[self.back])),
        )


def _torn_open(shape: Shape, torn: BoolArray) -> Opening:
    if torn_length(shape.mesh, torn) <= _LEAST_TORN:
        return Opening.nowhere(shape)
    return Opening.at(shape, torn)
