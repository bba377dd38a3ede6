"""What lies near the boundary of a surface, and how much is looked at to find it."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh import triangle_mesh
from solver.mesh.edges import edges_of
from solver.mesh.repair import boundary_of, denser_than
from tests.solver import shapes


class CountingTree(KDTree):
    """Counts the spheres that were searched, and the points that were listed."""

    searched = 0
    listed = 0

    def query_ball_point(self, x: Any, r: Any, *args: Any, **options: Any) -> Any:
        found = super().query_ball_point(x, r, *args, **options)
        self.searched += len(x)
        if not options.get("return_length"):
            self.listed += sum(map(len, found))
        return found


def fan(blades: int) -> tuple[FloatArray, IntArray]:
    """Triangles on one edge: vertices and faces; their tips are on the spheres over each other."""
    turn = np.linspace(0.0, 2.0 * np.pi, blades, endpoint=False)
    tips = np.stack([np.full(blades, 0.5), np.cos(turn), np.sin(turn)], axis=1)
    numbers = np.arange(2, blades + 2)
    faces = np.stack([np.zeros_like(numbers), np.ones_like(numbers), numbers], axis=1)
    return np.vstack([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], tips]), faces


@pytest.mark.parametrize("blades", [3000, 12000])
def test_a_tangle_is_known_from_a_few_spheres(blades: int) -> None:
    vertices, faces = fan(blades)
    assert boundary_of(vertices, faces, edges_of(faces)).crowded
    # Whether they lie in the spheres over the blades' sides or only close around.
    centre = 0.5 * (vertices[faces[:, 0]] + vertices[faces[:, 2]])
    radius = np.linalg.norm(vertices[faces[:, 2]], axis=1)
    for reach in (1.0, 0.5 * 1.1):
        tree = CountingTree(vertices)
        assert denser_than(tree, centre, reach * radius)
        assert (tree.searched, tree.listed) == (1024, 0)


def test_as_much_is_looked_at_as_there_is() -> None:
    points = np.random.default_rng(3).uniform(size=(5000, 3))
    radius = 0.05
    tree = CountingTree(points)
    held = int(tree.query_ball_point(points, radius, return_length=True).sum())
    tree.searched = 0
    assert not denser_than(tree, points, radius, -(-held // len(points)))
    assert (tree.searched, tree.listed) == (len(points), 0)
    assert denser_than(tree, points, radius, (held - 1) // len(points))


def test_a_boundary_beside_another_is_found() -> None:
    """Two squares, one with a vertex more on the side that they have in common."""
    left = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    right = [[1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 0.4, 0]]
    vertices = np.array(left + right, dtype=np.float64)
    faces = np.array([[0, 1, 2], [0, 2, 3], [8, 4, 5], [8, 5, 6], [8, 6, 7]])
    boundary = boundary_of(vertices, faces, edges_of(faces))
    assert not boundary.crowded
    number, vertex = boundary.vertices_beside(np.full(len(boundary.length), 1e-6))
    sides = np.stack([boundary.start, boundary.end], axis=1)[number]
    assert (np.sort(sides).tolist(), vertex.tolist()) == ([[1, 2]], [8])


@pytest.mark.parametrize("height", [1e-6, 1e-3, 0.05])
def test_a_flat_triangle_is_no_crack(height: float) -> None:
    """An ear at the corner of a sheet: its own third corner lies beside its longest side."""
    sheet = shapes.plane_grid()
    edge = sheet.vertices[1, 0]
    vertices = np.vstack([sheet.vertices, [-edge, -height * edge, 0.0]])
    ear = triangle_mesh(vertices, np.vstack([sheet.faces, [1, 0, len(vertices) - 1]]))
    assert (ear.n_faces, ear.warnings) == (sheet.n_faces + 1, ())
    alone = triangle_mesh(np.array([[0, 0, 0], [1, 0, 0], [0.5, height, 0]]), np.array([[0, 1, 2]]))
    assert (alone.n_faces, alone.warnings) == (1, ())
