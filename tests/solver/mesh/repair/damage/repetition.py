"""Faces, patches and whole surfaces that are there twice."""

from collections.abc import Mapping

import numpy as np

from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import Damage, Damaged, damaged_mesh


def faces_twice(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, faces=np.concatenate([mesh.faces, mesh.faces[::3]]))


def faces_twice_and_turned(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, faces=np.concatenate([mesh.faces, mesh.faces[::2, [1, 0, 2]]]))


def all_twice(mesh: TriangleMesh) -> Damaged:
    """The whole surface again, on vertices of its own."""
    return damaged_mesh(
        mesh,
        np.concatenate([mesh.vertices, mesh.vertices]),
        np.concatenate([mesh.faces, mesh.faces + mesh.n_vertices]),
    )


def all_twice_and_turned(mesh: TriangleMesh) -> Damaged:
    """The back of the surface as a surface of its own, as programs write that cull back faces."""
    return damaged_mesh(
        mesh,
        np.concatenate([mesh.vertices, mesh.vertices]),
        np.concatenate([mesh.faces, mesh.faces[:, ::-1] + mesh.n_vertices]),
    )


def a_patch_twice(mesh: TriangleMesh) -> Damaged:
    patch = mesh.faces[mesh.vertices[mesh.faces, 2].min(axis=1) > 0.2]
    return damaged_mesh(
        mesh,
        np.concatenate([mesh.vertices, mesh.vertices]),
        np.concatenate([mesh.faces, patch + mesh.n_vertices]),
    )


TOLD: Mapping[Damage, str] = {
    faces_twice: "repeating others",
    faces_twice_and_turned: "repeating others",
    all_twice: "dropped 1280 faces coinciding with others",
    all_twice_and_turned: "dropped 1280 faces coinciding with others",
    a_patch_twice: "faces coinciding with others",
}
"""With what the user is told."""
