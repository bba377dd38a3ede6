"""Faces without area, needles, caps and T-junctions."""

from collections.abc import Mapping

import numpy as np

from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import (
    Damage,
    Damaged,
    damaged_mesh,
    hinge,
    with_points,
)


def faces_with_a_corner_twice(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, faces=np.concatenate([mesh.faces[:9, [0, 1, 1]], mesh.faces]))


def flat_faces(mesh: TriangleMesh) -> Damaged:
    """Triangles of an edge and its middle, which belongs to no other face."""
    ends = mesh.edges[::40]
    middles = mesh.vertices[ends].mean(axis=1)
    numbers = mesh.n_vertices + np.arange(len(ends))
    return damaged_mesh(
        mesh,
        with_points(mesh, middles),
        np.concatenate([mesh.faces, np.column_stack([ends, numbers])]),
    )


def _split_vertex(mesh: TriangleMesh, apart: float) -> Damaged:
    """Make two of a vertex, half of its faces each, joined by two needles."""
    v = 17
    ring = []  # its neighbours, counterclockwise
    following = {}
    for face in mesh.faces[(mesh.faces == v).any(axis=1)].tolist():
        at = face.index(v)
        following[face[(at + 1) % 3]] = face[(at + 2) % 3]
    neighbour = next(iter(following))
    while neighbour not in ring:
        ring.append(neighbour)
        neighbour = following[neighbour]
    half = ring[: len(ring) // 2 + 1]
    new = mesh.n_vertices
    faces = mesh.faces.tolist()
    for face in faces:
        if v in face and all(corner == v or corner in half for corner in face):
            face[face.index(v)] = new
    faces += [[v, half[0], new], [new, half[-1], v]]
    step = apart * (mesh.vertices[half[len(half) // 2]] - mesh.vertices[v])
    return damaged_mesh(mesh, with_points(mesh, mesh.vertices[v] + step), faces)


def needles_of_no_length(mesh: TriangleMesh) -> Damaged:
    return _split_vertex(mesh, 0.0)


def needles(mesh: TriangleMesh) -> Damaged:
    return _split_vertex(mesh, 1e-9)


def caps(mesh: TriangleMesh) -> Damaged:
    """The middle of an edge, a corner on its one side only, and a flat face between."""
    f, _, i, j, a, _ = hinge(mesh)
    m = mesh.n_vertices
    faces = [face for number, face in enumerate(mesh.faces.tolist()) if number != f]
    middle = mesh.vertices[[i, j]].mean(axis=0)
    return damaged_mesh(mesh, with_points(mesh, middle), [*faces, [i, m, a], [m, j, a], [j, m, i]])


def t_junction(mesh: TriangleMesh) -> Damaged:
    """The same without the flat face: a crack of no width."""
    damaged = caps(mesh)
    return damaged_mesh(mesh, damaged.vertices, damaged.faces[:-1])


def t_junctions_on_both_sides(mesh: TriangleMesh) -> Damaged:
    """One side of an edge has corners at its first third, the other at its second."""
    f, g, i, j, a, b = hinge(mesh)
    m, n = mesh.n_vertices, mesh.n_vertices + 1
    faces = [face for number, face in enumerate(mesh.faces.tolist()) if number not in (f, g)]
    start, end = mesh.vertices[[i, j]]
    points = start + (end - start) / 3.0, start + 2.0 * (end - start) / 3.0
    faces += [[i, m, a], [m, j, a], [j, n, b], [n, i, b]]
    return damaged_mesh(mesh, with_points(mesh, *points), faces)


def t_junctions_and_seams(mesh: TriangleMesh) -> Damaged:
    """All faces loose, and T-junctions among them."""
    damaged = t_junctions_on_both_sides(mesh)
    corners = np.array(damaged.faces)
    where = np.full(mesh.n_vertices, -1)
    flat = corners.reshape(-1)
    old = flat < mesh.n_vertices
    where[flat[old][::-1]] = np.flatnonzero(old)[::-1]
    loose = np.arange(corners.size).reshape(-1, 3)
    return Damaged(damaged.vertices[flat], loose.tolist(), where)


TOLD: Mapping[Damage, str] = {
    faces_with_a_corner_twice: "dropped 9 faces using a vertex twice",
    flat_faces: "faces without area",
    needles_of_no_length: "merged 1 vertex into a neighbour at the same position",
    needles: "merged 1 vertex into a neighbour at the same position",
    caps: "closed cracks: split 1 face at 1 vertex",
    t_junction: "closed cracks: split 1 face at 1 vertex",
    t_junctions_on_both_sides: "closed cracks: split 2 faces at 2 vertices",
    t_junctions_and_seams: "closed cracks: split 2 faces at 2 vertices",
}
"""With what the user is told."""
