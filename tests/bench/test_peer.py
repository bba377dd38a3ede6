"""Both sides of the comparison read the same meshes."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.collection import KnownShape
from bench.peer import write_pair
from solver.mesh import read_mesh, triangle_mesh
from solver.shape import Shape
from synthetic import human


def test_meshes_are_read_as_they_were_written(tmp_path: Path) -> None:
    figure = human("sitting", resolution=300)
    mesh = triangle_mesh(figure.vertices, figure.faces)
    one = KnownShape("one", "one", Shape(mesh), None, None)
    other = replace(one, shape=Shape(triangle_mesh(figure.vertices / 3.0, figure.faces)))
    for path, known in zip(write_pair((one, other), tmp_path), (one, other), strict=True):
        again = read_mesh(path.read_bytes(), "off")
        np.testing.assert_array_equal(again.vertices, known.shape.mesh.vertices)
        np.testing.assert_array_equal(again.faces, known.shape.mesh.faces)
