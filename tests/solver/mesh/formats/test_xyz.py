"""Point clouds as text: columns, separators, headers, and what is refused."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.errors import MeshError
from solver.mesh import read_mesh
from solver.mesh.formats.xyz import read_xyz

POINTS = np.array([[0.0, 0, 0], [1, 0, 0.5], [1, -1, 0], [0, 1, 2.25]])
NORMALS = np.array([[0.0, 0, 1], [1, 0, 0], [0.6, 0.8, 0], [0, -1, 0]])
COLORS = np.array([[255.0, 0, 0], [0, 128, 0], [0, 0, 64], [255, 255, 255]])


def text(table: FloatArray, separator: str = " ", header: str = "") -> bytes:
    lines = [separator.join(f"{number:g}" for number in row) for row in table]
    return (header + "\n".join(lines) + "\n").encode()


@pytest.mark.parametrize("separator", [" ", ",", ";", "\t", ", "])
@pytest.mark.parametrize("header", ["", "x,y,z\n", "4\n", "# by hand\n\n", "// scan\n"])
def test_points_are_read_in_their_order(separator: str, header: str) -> None:
    found = read_xyz(text(POINTS, separator, header))
    np.testing.assert_array_equal(found.vertices, POINTS)
    np.testing.assert_array_equal(found.vertex_ids, np.arange(4))
    assert found.is_cloud
    assert len(found.faces) == 0
    assert found.normals is None
    assert found.colors is None


def test_further_columns_are_normals_or_colours() -> None:
    found = read_xyz(text(np.hstack([POINTS, NORMALS, COLORS])))
    assert found.normals is not None
    np.testing.assert_allclose(found.normals, NORMALS)
    assert found.colors is None
    found = read_xyz(text(np.hstack([POINTS, COLORS])))
    assert found.normals is None
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, COLORS / 255.0)
    found = read_xyz(text(np.hstack([POINTS, 1000.0 * COLORS])))
    assert found.normals is None
    assert found.colors is None


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "empty"),
        (b"# nothing\n", "no points"),
        (b"x y z\n", "no points"),
        (b"Dear reader,\nthis is a letter.\n", "point line"),
        (b"1 2\n3 4\n", "x, y and z are needed"),
        (b"1 2 3\n4 5\n", "point line"),
        (b"1 2 3\n4 five 6\n", "point line"),
        (b"3\n1 2 3\n4 5 6\n", "promises 3 points and has 2"),
        (b"1 2 3\n4 5 6\n", "20 points or more in different places; there are 2"),
    ],
)
def test_what_is_refused(data: bytes, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_mesh(data, "xyz")
