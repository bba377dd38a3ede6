"""Faces whose corners go round the other way."""

from collections.abc import Mapping

import numpy as np

from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import (
    Damage,
    Damaged,
    centroids,
    damaged_mesh,
    generator,
)


def faces_turned_at_random(mesh: TriangleMesh) -> Damaged:
    turned = generator().random(mesh.n_faces) < 0.3
    return damaged_mesh(mesh, faces=np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces))


def one_half_turned(mesh: TriangleMesh) -> Damaged:
    turned = centroids(mesh)[:, 0] > 0.0
    return damaged_mesh(mesh, faces=np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces))


def inside_out(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, faces=mesh.faces[:, ::-1])


def mirrored(mesh: TriangleMesh) -> Damaged:
    """Coordinates mirrored, faces not: an isometry, inside out."""
    return damaged_mesh(mesh, mesh.vertices * np.array([-1.0, 1.0, 1.0]))


TOLD: Mapping[Damage, str] = {
    faces_turned_at_random: "to agree with neighbouring faces",
    one_half_turned: "to agree with neighbouring faces",
    inside_out: "it was inside out",
    mirrored: "it was inside out",
}
"""With what the user is told."""
