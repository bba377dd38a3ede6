"""Winding: consistent, and outward where a surface is closed or has small holes."""

import numpy as np

from solver.mesh import face_normals, triangle_mesh
from tests.solver import shapes


def test_open_surfaces_keep_their_winding_where_it_agrees() -> None:
    sheet = shapes.plane_grid()
    bent = sheet.vertices + np.array([0.0, 0.0, 1.0]) * sheet.vertices[:, :1] ** 2
    for faces in (sheet.faces, sheet.faces[:, ::-1]):
        mesh = triangle_mesh(bent, faces)
        np.testing.assert_array_equal(mesh.faces, faces)
        assert mesh.warnings == ()


def test_a_surface_with_small_holes_has_an_inside() -> None:
    original = shapes.blob(3)
    pierced = np.delete(original.faces, [3, 400, 900], axis=0)
    assert triangle_mesh(original.vertices, pierced).warnings == ()
    turned = triangle_mesh(original.vertices, pierced[:, ::-1])
    assert turned.warnings == ("flipped all faces of the surface: it was inside out",)
    np.testing.assert_array_equal(turned.faces, pierced)


def test_a_body_without_a_side_has_an_inside() -> None:
    whole = shapes.blob(3)
    left = whole.faces[(whole.vertices[whole.faces, 0] > -0.5).all(axis=1)]
    for faces in (left, left[:, ::-1]):
        mesh = triangle_mesh(whole.vertices, faces)
        outwards = face_normals(mesh.vertices, mesh.faces) * mesh.vertices[mesh.faces].mean(axis=1)
        assert outwards.sum() > 0.0
        assert mesh.relative_boundary > 1.0


def test_pieces_that_were_inside_out_are_counted() -> None:
    """As the inner wall of a shell, whose normals point into it."""
    ball = shapes.icosphere()
    vertices = np.concatenate([ball.vertices, 0.9 * ball.vertices])
    faces = np.concatenate([ball.faces, ball.faces[:, ::-1] + ball.n_vertices])
    (said,) = [one for one in triangle_mesh(vertices, faces).warnings if "inside out" in one]
    assert said == "flipped all faces of 1 of 2 pieces, which were inside out"
