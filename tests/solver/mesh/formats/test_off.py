"""OFF: its dialects, its colours, and what is broken."""

import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver.mesh.mesh_files import SQUARE, TWO


@pytest.mark.parametrize(
    "text",
    [
        "OFF 4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
        "OFF4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
        "# first\nOFF # here\n\n4 2\n0 0 0 # a\n1 0 0\n\n1 1 0\n0 1 0\n"
        "3 0 1 2 255 0 0\n3 0 2 3 1 1 1\n",
        "OFF\r\n4 1 0\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n4 0 1 2 3\r\n",
        "NOFF\n4 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3\n",
    ],
)
def test_dialects_of_off(text: str) -> None:
    mesh = read_mesh(text.encode(), "off")
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    assert mesh.faces.tolist() == TWO
    assert mesh.colors is None


@pytest.mark.parametrize(
    ("header", "colors"),
    [
        ("COFF", "255 0 51 255"),
        ("COFF", "1.0 0.0 0.2"),
        ("OFF", "255 0 51"),
        ("CNOFF", "0 0 1 1. 0 .2"),
    ],
)
def test_colors_of_off(header: str, colors: str) -> None:
    rows = [f"{x} {y} {z} {colors}" for x, y, z in SQUARE.tolist()]
    mesh = read_mesh("\n".join([header, "4 1 0", *rows, "4 0 1 2 3\n"]).encode(), "off")
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors, np.tile([1.0, 0.0, 0.2], (4, 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("OFF\n", "ends before"),
        ("OFF\nx y z\n", "counts"),
        ("OFF\n-4 2 0\n", "negative"),
        ("OFF BINARY\n", "binary OFF"),
        ("4OFF\n1 0 0\n0 0 0 0\n", "only OFF"),
        ("OFF\n3 1 0\n0 0\n1 0\n1 1\n3 0 1 2\n", "fewer than three"),
        ("OFF\n3 1 0\n0 0 0\n1 0 zero\n1 1 0\n3 0 1 2\n", "vertex line"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 two\n", "face line"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 0_2\n", "face line"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 3\n", "vertex 3"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 -1\n", "vertex -1"),
        (f"OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 {10**20}\n", "read: a number in it is too large"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1\n", "promises 3 values and has 2"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n2 0 1\n", "2 corners"),
        ("OFF\n3 1 0\n0 0 0\n1 0 nan\n1 1 0\n3 0 1 2\n", "not a finite number"),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n1 1 0\n", "no faces"),
    ],
)
def test_broken_off(text: str, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_mesh(text.encode(), "off")
