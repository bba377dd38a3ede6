"""Reduction: surfaces with fewer of their vertices, on which candidates are compared.

What a registration compares is of some hundredths of √area: ten thousand vertices resolve it where
surfaces are opened or searched for parts, and a thousand tell which candidate fits best once it is
refined. Only the answer is refined on all.
"""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import IntArray
from solver.mesh import simplified
from solver.registration.alignment import LOCAL, Alignment, Pairs
from solver.registration.candidates import Points
from solver.registration.choice import Stage, Task
from solver.registration.opening import VertexMaps
from solver.registration.surface import Samples
from solver.shape import Shape

MANY_VERTICES = 10_000
"""Vertices that surfaces are simplified to: their edges are some 0.01 √area long, half of the
length over which a displaced surface is rigid."""

FEW_VERTICES = 1_000
"""Vertices that are enough to tell which candidates may be the best once refined."""

_SPARED = 1.5
"""Factor on the number of vertices left, up to which a surface stays as it is."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """A shape with fewer of its vertices.

    Parameters
    ----------
    shape
        The simplified shape; one of few vertices itself.
    vertices
        (K,) its vertices, in the numbers of the whole shape.
    index_of_vertex
        (V,) index among these of the vertex that each vertex of the whole shape was collapsed into.
    """

    shape: Shape
    vertices: IntArray
    index_of_vertex: IntArray

    @classmethod
    def of(cls, shape: Shape, left: int) -> "Reduction":
        """Simplify a shape to a number of vertices, if it has many more."""
        whole, every = shape.mesh, np.arange(shape.n_vertices)
        if shape.n_vertices <= _SPARED * left:
            return cls(shape, every, every)
        mesh = simplified(whole, left)
        vertices, index = (
            one.vertices_of(other.vertex_ids) for one, other in ((whole, mesh), (mesh, whole))
        )
        lost = np.flatnonzero(index < 0)
        index[lost] = KDTree(mesh.vertices).query(whole.vertices[lost])[1]
        return cls(shape.with_mesh(mesh), vertices, index)


_REDUCTIONS: "WeakKeyDictionary[Shape, dict[int, Reduction]]" = WeakKeyDictionary()


def reduction(shape: Shape, left: int | None = None) -> Reduction:
    """Return the reduction of a shape, computed once for each shape and number.

    Parameters
    ----------
    shape
        The shape.
    left
        Vertices that it is simplified to, :data:`MANY_VERTICES` by default.
    """
    left = left or MANY_VERTICES
    if shape.n_vertices <= _SPARED * left:
        # Not kept: it would keep the shape.
        return Reduction.of(shape, left)
    known = _REDUCTIONS.setdefault(shape, {})
    if left not in known:
        known[left] = Reduction.of(shape, left)
    return known[left]


@dataclass(frozen=True, eq=False)
class ReducedTask:
    """A task on reduced surfaces.

    Parameters
    ----------
    task
        On them.
    whole
        Samples of the whole surfaces at the vertices of the task's samples.
    """

    task: Task
    whole: tuple[Samples, Samples]

    @classmethod
    def entire(cls, task: Task) -> "ReducedTask":
        """Return a task on all vertices."""
        return cls(task, task.samples)

    @classmethod
    def of(cls, source: Shape, target: Shape, task: Task, left: int) -> "ReducedTask":
        """Reduce the surfaces of a task, without its landmarks; the task where both have few.

        Parameters
        ----------
        source, target
            Its shapes.
        task
            On them.
        left
            Vertices that they are simplified to.
        """
        fewer = reduction(source, left), reduction(target, left)
        if fewer[0].shape is source and fewer[1].shape is target:
            return cls.entire(task)
        reduced = Task.of(fewer[0].shape, fewer[1].shape)
        here, there = (
            surface.at(one.vertices[samples.vertices])
            for surface, one, samples in zip(
                (task.source, task.target), fewer, reduced.samples, strict=True
            )
        )
        if task.is_reflected:
            return cls(reduced.reflected(), (here.reflected(), there))
        return cls(reduced, (here, there))

    def pairs(self, alignment: Alignment, stage: Stage) -> Pairs:
        """Pairs of a stage's samples of the reduced surfaces, by an alignment of the whole ones."""
        source, target = self.whole
        here, there = source.first(stage.source_samples), target.first(stage.target_samples)
        return alignment.pairs(here, there, LOCAL)


def reduced_landmarks(source: Reduction, target: Reduction, landmarks: Points) -> Points:
    """Return landmarks of whole shapes on reduced ones, where several may become one."""
    here, there = source.index_of_vertex[landmarks[0]], target.index_of_vertex[landmarks[1]]
    first, other = (np.unique(one, return_index=True)[1] for one in (here, there))
    kept = np.intersect1d(first, other)
    return here[kept], there[kept]


def whole_maps(maps: VertexMaps, source: Reduction, target: Reduction) -> VertexMaps:
    """Return the maps of all vertices of the whole shapes that maps of the reduced ones give."""
    return VertexMaps(
        target.vertices[maps.images[source.index_of_vertex]],
        source.vertices[maps.back[target.index_of_vertex]],
    )


def reduced_maps(maps: VertexMaps, source: Reduction, target: Reduction) -> VertexMaps:
    """Return the maps of the vertices of reduced shapes that maps of the whole ones give."""
    return VertexMaps(
        target.index_of_vertex[maps.images[source.vertices]],
        source.index_of_vertex[maps.back[target.vertices]],
    )
