"""The surface enlarged, far away, or written with few digits."""

from collections.abc import Mapping

import numpy as np

from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import Damage, Damaged, damaged_mesh
from tests.solver.mesh.repair.damage.seams import crossing_seams


def scaled_up(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, 1e12 * mesh.vertices, scale=1e12)


def scaled_down(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, 1e-12 * mesh.vertices, scale=1e-12)


def huge(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, 1e30 * mesh.vertices, scale=1e30)


def tiny(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, 1e-30 * mesh.vertices, scale=1e-30)


def moved_by_a_million(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, mesh.vertices + 1e6)


def moved_by_a_hundred_million(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, mesh.vertices - 1e8)


def huge_and_far_away(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, 1e38 * mesh.vertices + 1e41, scale=1e38)


def small_and_far_away(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, 1e-3 * mesh.vertices + 1e3, scale=1e-3)


def in_single_precision(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, mesh.vertices.astype(np.float32).astype(np.float64))


def seams_in_single_precision_far_away(mesh: TriangleMesh) -> Damaged:
    damaged = crossing_seams(mesh)
    vertices = (damaged.vertices + 300.0).astype(np.float32).astype(np.float64)
    return Damaged(vertices, damaged.faces, damaged.where)


TOLD: Mapping[Damage, str] = {
    in_single_precision: "",
    seams_in_single_precision_far_away: "closed seams",
    scaled_up: "",
    scaled_down: "",
    huge: "",
    tiny: "",
    moved_by_a_million: "",
    moved_by_a_hundred_million: "",
    huge_and_far_away: "",
    small_and_far_away: "",
}
"""With what the user is told."""
