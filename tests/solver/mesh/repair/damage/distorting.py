"""Damages that make another surface, in a way that nobody can undo."""

from collections.abc import Mapping

import numpy as np

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import (
    Damage,
    Damaged,
    damaged_mesh,
    hinge,
    jittered,
    with_points,
)
from tests.solver.mesh.repair.damage.degenerate import t_junction
from tests.solver.mesh.repair.damage.seams import a_seam


def a_fin(mesh: TriangleMesh) -> Damaged:
    """A third face on an edge."""
    _, _, i, j, a, _ = hinge(mesh)
    tip = 2.0 * mesh.vertices[i] - mesh.vertices[a]
    faces = [*mesh.faces.tolist(), [i, j, mesh.n_vertices]]
    return damaged_mesh(mesh, with_points(mesh, tip), faces)


def an_interior_wall(mesh: TriangleMesh) -> Damaged:
    """A face through the inside, which touches the surface in its corners."""
    return damaged_mesh(mesh, faces=[*mesh.faces.tolist(), [0, 200, 400]])


def glued_points(mesh: TriangleMesh) -> Damaged:
    """Two vertices far apart are one."""
    return damaged_mesh(mesh, faces=np.where(mesh.faces == 7, 300, mesh.faces))


def a_wide_crack(mesh: TriangleMesh) -> Damaged:
    return jittered(a_seam(mesh), 1e-3)


def a_wide_t_junction(mesh: TriangleMesh) -> Damaged:
    damaged = t_junction(mesh)
    vertices = damaged.vertices.copy()
    vertices[-1] += 0.003
    return damaged_mesh(mesh, vertices, damaged.faces)


def coarse_for_its_place(mesh: TriangleMesh) -> Damaged:
    moved = (mesh.vertices + 1e4).astype(np.float32).astype(np.float64)
    return damaged_mesh(mesh, moved)


def seven_digits_for_its_place(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, np.round(mesh.vertices + 1e3, 3))


def crossed_polygons(mesh: TriangleMesh) -> Damaged:
    """Two neighbouring faces as one quadrilateral whose corners are in the wrong order."""
    f, g, i, j, a, b = hinge(mesh)
    faces = [face for number, face in enumerate(mesh.faces.tolist()) if number not in (f, g)]
    return damaged_mesh(mesh, faces=[*faces, [i, j, a, b]])


def _strip(around: int = 24) -> tuple[FloatArray, list[list[int]]]:
    angles = 2.0 * np.pi * np.arange(around) / around
    rows = []
    for s in (-0.3, 0.3):
        reach = 1.0 + s * np.cos(angles / 2)
        height = s * np.sin(angles / 2)
        rows.append(np.stack([reach * np.cos(angles), reach * np.sin(angles), height], axis=1))
    faces = [[n, n + 1, around + n + 1, around + n] for n in range(around - 1)]
    last = around - 1
    return np.concatenate(rows), [*faces, [last, around, 0, around + last]]


def one_sided(mesh: TriangleMesh) -> Damaged:
    """A Möbius strip of quadrilaterals, and nothing of the mesh."""
    vertices, faces = _strip()
    return Damaged(vertices, faces, np.full(mesh.n_vertices, -1))


DISTORTING: Mapping[Damage, str] = {
    a_fin: "1 non-manifold edge with more than two faces",
    an_interior_wall: "3 non-manifold vertices at which the surface only touches itself",
    glued_points: "1 non-manifold vertex at which the surface only touches itself",
    a_wide_crack: "boundary vertices nearly on another boundary edge",
    a_wide_t_junction: "1 boundary vertex nearly on another boundary edge",
    coarse_for_its_place: "distances are no more precise",
    seven_digits_for_its_place: "distances are no more precise",
    crossed_polygons: "1 face whose outline crosses itself",
    one_sided: "not orientable",
}
"""The surface is another one, in a way that nobody can undo; with what the user is told."""
