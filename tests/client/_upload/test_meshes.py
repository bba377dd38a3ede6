"""What is uploaded for a mesh that a user holds in memory."""

import io
import subprocess
import sys
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
import trimesh
from isomatch._upload import MeshSource, attribute_file, binary_ply, mesh_file

TETRAHEDRON = (
    np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, 1 / 3], [0.0, 0.0, np.pi]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)
OFF = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


def read_back(data: bytes) -> trimesh.Trimesh:
    return trimesh.load_mesh(io.BytesIO(data), file_type="ply", process=False)


def content(source: MeshSource, file_type: str | None = None) -> tuple[str, bytes]:
    with mesh_file(source, file_type) as file:
        data = file.content if isinstance(file.content, bytes) else file.content.read()
        return file.name, data


def test_arrays_are_written_exactly() -> None:
    name, data = content(TETRAHEDRON)
    mesh = read_back(data)
    assert name == "mesh.ply"
    np.testing.assert_array_equal(mesh.vertices, TETRAHEDRON[0])
    np.testing.assert_array_equal(mesh.faces, TETRAHEDRON[1])


def test_order_and_unused_vertices_are_kept() -> None:
    vertices = np.vstack([[[9.0, 9.0, 9.0]], TETRAHEDRON[0]])
    mesh = read_back(binary_ply(vertices, TETRAHEDRON[1] + 1))
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.faces, TETRAHEDRON[1] + 1)


def test_a_trimesh_is_written_with_its_vertex_colours() -> None:
    colors = np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [7, 8, 9, 255]])
    mesh = trimesh.Trimesh(*TETRAHEDRON, vertex_colors=colors, process=False)
    back = read_back(content(mesh)[1])
    assert isinstance(back.visual, trimesh.visual.ColorVisuals)
    np.testing.assert_array_equal(back.visual.vertex_colors[:, :3], colors[:, :3])


COLORS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [7, 8, 9]], dtype=np.uint8)


def test_a_geometry_is_written_with_its_colours() -> None:
    geometry = isomatch.Geometry(*TETRAHEDRON, np.arange(4), COLORS)
    assert content(geometry) == ("mesh.ply", binary_ply(*TETRAHEDRON, COLORS))
    plain = isomatch.Geometry(*TETRAHEDRON, np.arange(4), None)
    assert content(plain) == ("mesh.ply", binary_ply(*TETRAHEDRON))
    cloud = isomatch.Geometry(*TETRAHEDRON, np.arange(4), COLORS, is_cloud=True)
    name, data = content(cloud)
    assert name == "points.ply"
    assert b"element face" not in data
    assert b"property uchar red" in data


def test_colours_of_faces_are_not_lost_in_silence() -> None:
    mesh = trimesh.Trimesh(*TETRAHEDRON, face_colors=COLORS, process=False)
    with pytest.warns(UserWarning, match=r"colours of faces .* mesh\.visual\.vertex_colors"):
        assert content(mesh)[1] == binary_ply(*TETRAHEDRON)


class Vectors:
    """Numbers as open3d has them: no array, but convertible to one."""

    def __init__(self, values: np.ndarray) -> None:
        self.values = values

    def __len__(self) -> int:
        return len(self.values)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self.values, dtype)


class TriangleMesh:
    """A mesh like those of open3d."""

    def __init__(self, colors: np.ndarray) -> None:
        self.vertices, self.triangles = map(Vectors, TETRAHEDRON)
        self.vertex_colors = Vectors(colors)


def test_a_mesh_of_open3d_is_written() -> None:
    colored: Any = TriangleMesh(COLORS / 255.0)
    assert content(colored) == ("mesh.ply", binary_ply(*TETRAHEDRON, COLORS))
    plain: Any = TriangleMesh(np.zeros((0, 3)))
    assert content(plain) == ("mesh.ply", binary_ply(*TETRAHEDRON))


def test_a_point_cloud_of_trimesh_is_written() -> None:
    made: Any = trimesh.PointCloud
    assert content(made(TETRAHEDRON[0])) == content(TETRAHEDRON[0])
    colored = made(TETRAHEDRON[0], colors=COLORS)
    assert content(colored) == content((TETRAHEDRON[0], None, COLORS))


def test_a_scene_of_trimesh_is_refused_with_what_to_do() -> None:
    scene: Any = trimesh.Scene([trimesh.Trimesh(*TETRAHEDRON)])
    with pytest.raises(TypeError, match=r"use scene\.to_mesh\(\)"):
        content(scene)


def test_the_same_arrays_have_the_same_bytes() -> None:
    as_lists = tuple(array.tolist() for array in TETRAHEDRON)
    assert content((as_lists[0], as_lists[1]))[1] == binary_ply(*TETRAHEDRON)


def test_files_bytes_and_paths_are_sent_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "a.off"
    path.write_bytes(OFF)
    assert content(path) == ("a.off", OFF)
    assert content(str(path)) == ("a.off", OFF)
    assert content(OFF, "off") == ("mesh.off", OFF)
    assert content(io.BytesIO(OFF), ".OFF") == ("mesh.off", OFF)
    with path.open("rb") as file:
        assert content(file) == ("a.off", OFF)
    renamed = path.rename(tmp_path / "a.txt")
    assert content(renamed, "off") == ("a.off", OFF)


POINTS, CORNERS = np.eye(4, 3), np.array([[0, 1, 2]])
NAN_Y = np.array([0.0, np.nan, 0.0])


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (OFF, "file_type="),
        (io.BytesIO(OFF), "file_type="),
        ((np.zeros((4, 2)), CORNERS), r"vertices must have the shape \(n, 3\), not \(4, 2\)"),
        ((np.zeros(12), CORNERS), r"vertices must have the shape"),
        (([[0.0, 0.0, 0.0], [1.0]], CORNERS), "vertices must be an array"),
        ((POINTS.astype(complex), CORNERS), "real numbers, not complex"),
        ((POINTS.astype(str), CORNERS), "real numbers, not <U"),
        ((POINTS, np.zeros((1, 4), dtype=int)), "faces must have the shape"),
        (
            (POINTS, np.zeros((1, 3))),
            r"faces must be integers, not float64; use faces.astype\(int\)",
        ),
        ((POINTS, np.zeros((0, 3), dtype=int)), "one triangle"),
        ((POINTS, None), "for a point cloud, give the points alone"),
        ((POINTS, CORNERS + 2), r"faces\[0, 2\] is 4, but vertices count from 0 to 3"),
        ((POINTS, CORNERS - 1), r"faces\[0, 0\] is -1"),
        ((POINTS, np.full((1, 3), 2**40)), "faces"),
        (
            (POINTS + np.array([0.0, np.nan, 0.0]), CORNERS),
            r"vertices\[0\] is .*nan.* must be finite",
        ),
        ((POINTS + np.array([0.0, 0.0, np.inf]), CORNERS), "must be finite"),
        ((POINTS, CORNERS, np.zeros((3, 3))), r"colors must have the shape \(4, 3\)"),
        ((POINTS, CORNERS, np.full((4, 3), 256)), "between 0 and 255"),
        ((POINTS, CORNERS, np.full((4, 3), 1.5)), "between 0 and 1"),
        ((POINTS, CORNERS, np.full((4, 3), np.nan)), "between 0 and 1"),
        ((POINTS, CORNERS, np.full((4, 3), "red")), "integers or floats"),
    ],
)
def test_invalid_arrays_are_refused(source: MeshSource, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        content(source)


def test_unused_vertices_may_be_nan() -> None:
    points = np.vstack([POINTS, [[np.nan] * 3]])
    np.testing.assert_array_equal(read_back(binary_ply(points, CORNERS)).faces, CORNERS)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.int64, np.uint8, np.bool_])
def test_all_numeric_types_are_accepted(kind: type[np.generic]) -> None:
    points = np.eye(3).astype(kind)
    np.testing.assert_array_equal(read_back(binary_ply(points, [[0, 1, 2]])).vertices, np.eye(3))


def test_colours_are_bytes_or_floats() -> None:
    given = np.array([[0, 51, 255, 9]] * 4)
    as_bytes = binary_ply(POINTS, CORNERS, given.astype(np.uint8))
    assert as_bytes == binary_ply(POINTS, CORNERS, given[:, :3])
    assert as_bytes == binary_ply(POINTS, CORNERS, given / 255.0)
    assert as_bytes == content((POINTS, CORNERS, given))[1]
    back = read_back(as_bytes)
    assert isinstance(back.visual, trimesh.visual.ColorVisuals)
    np.testing.assert_array_equal(back.visual.vertex_colors[:, :3], given[:, :3])


def test_optional_packages_are_not_imported() -> None:
    program = "import sys, isomatch; assert not {'trimesh', 'plotly', 'trio'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_other_types_are_refused() -> None:
    with pytest.raises(TypeError, match="not int"):
        content(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="not a tuple of 1"):
        content((POINTS,))  # type: ignore[arg-type]


def test_a_path_that_does_not_exist_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        content(tmp_path / "nothing.off")


@pytest.mark.parametrize("columns", [3, 6])
def test_an_array_of_points_is_a_cloud(columns: int) -> None:
    given = np.random.default_rng(1).random((30, columns))
    given[:, 3:] /= np.linalg.norm(given[:, 3:], axis=1, keepdims=True)
    name, data = content(given)
    assert name == "points.ply"
    header, _, body = data.partition(b"end_header\n")
    assert header.count(b"property double") == columns
    assert b"element face" not in header
    np.testing.assert_array_equal(np.frombuffer(body, "<f8").reshape(30, columns), given)
    with pytest.raises(ValueError, match=r"must have the shape \(V, 3\) or \(V, 6\)"):
        content(given[:, :2])


@pytest.mark.parametrize("extra", [[255.0, 0.0, 7.0], [0.5, 0.5, 0.5], [np.inf, 0.0, 0.0]])
def test_columns_that_are_no_normals_are_refused(extra: list[float]) -> None:
    given = np.array([[0.0, 0, 0, 0, 0, 1], [1, 0, 0, *extra], [0, 1, 0, 0, 1, 0]])
    with pytest.raises(ValueError, match=r"points\[1, 3:\] is .* give colours as \(points, None"):
        content(given)


def test_normals_may_be_missing() -> None:
    given = np.array([[0.0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0], [0, 1, 0, *[np.nan] * 3]])
    assert content(given)[0] == "points.ply"


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.array([1, None]), "'height' is an array of objects: give numbers"),
        ([[1.0], [1.0, 2.0]], "'height' is no array: "),
    ],
)
def test_arrays_that_no_file_holds_are_named(values: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message), attribute_file({"height": values}):
        pass
