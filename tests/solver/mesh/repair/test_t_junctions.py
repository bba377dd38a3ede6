"""T-junctions: the faces at them are split, and no crack or flat face is left."""

import numpy as np
import pytest

from solver.mesh import triangle_mesh


@pytest.mark.parametrize("seed", range(4))
def test_several_vertices_on_one_edge(seed: int) -> None:
    """A triangle beside a fan of triangles whose rim lies on its side, somewhere in space."""
    random = np.random.default_rng(seed)
    along = np.r_[0.0, np.sort(random.random(6)), 1.0]
    rim = np.stack([along, 0.0 * along], axis=1)
    plane = np.concatenate([rim, [[0.5, 1.0], [0.5, -1.0]]])
    rotation, _ = np.linalg.qr(random.standard_normal((3, 3)))
    fan = [[k, k + 1, 8] for k in range(7)]
    mesh = triangle_mesh(
        plane @ rotation[:2] + random.standard_normal(3), np.array([*fan, [7, 0, 9]])
    )
    assert mesh.warnings == ("closed cracks: split 1 face at 6 vertices within an edge",)
    assert (mesh.n_vertices, mesh.n_faces) == (10, 14)
    # Euler characteristic and boundary of a disc: the crack is closed.
    assert mesh.n_vertices - len(mesh.edges) + mesh.n_faces == 1
    assert mesh.area == pytest.approx(1.0)


def test_a_vertex_that_touches_an_edge_stays_apart() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 0, 0], [0, -1, 0], [1, -1, 0]])
    mesh = triangle_mesh(vertices, np.array([[0, 1, 2], [3, 4, 5]]))
    assert (mesh.components, mesh.n_faces) == (2, 2)
