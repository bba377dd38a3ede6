"""LAS and LAZ, as another program writes them: points, colours, normals, and what is refused."""

import io
from typing import Any

import laspy
import numpy as np
import pytest

from solver.errors import MeshError
from solver.mesh import read_mesh
from solver.mesh.formats.las import read_las
from tests.solver import shapes
from tests.solver.mesh.textures.textured_files import zipped

SPHERE = shapes.blob(3)
SCALE = 1e-4


def written(
    points: np.ndarray, *, compressed: bool = False, version: str = "1.2", **dimensions: np.ndarray
) -> bytes:
    """A file of points, with colours and extra dimensions."""
    colored = "red" in dimensions
    plain, with_colors = (6, 7) if version == "1.4" else (0, 2)
    header = laspy.LasHeader(point_format=with_colors if colored else plain, version=version)
    header.scales, header.offsets = np.full(3, SCALE), np.floor(points.min(axis=0))
    for name in dimensions:
        if name not in ("red", "green", "blue"):
            header.add_extra_dim(laspy.ExtraBytesParams(name=name, type=np.float64))
    file: Any = laspy.LasData(header)
    file.xyz = points
    for name, values in dimensions.items():
        file[name] = values
    stream = io.BytesIO()
    file.write(stream, do_compress=compressed)
    return stream.getvalue()


@pytest.mark.parametrize("version", ["1.2", "1.4"])
@pytest.mark.parametrize("compressed", [False, True])
def test_points_are_scaled_and_in_their_order(version: str, compressed: bool) -> None:
    points = SPHERE.vertices + np.array([500_000.0, 4_000_000.0, 120.0])
    found = read_las(written(points, compressed=compressed, version=version))
    np.testing.assert_allclose(found.vertices, points, atol=0.51 * SCALE)
    np.testing.assert_array_equal(found.vertex_ids, np.arange(len(points)))
    assert found.is_cloud
    assert found.colors is None
    assert found.normals is None


@pytest.mark.parametrize("names", [("NormalX", "NormalY", "NormalZ"), ("nx", "ny", "nz")])
def test_normals_and_colours(names: tuple[str, str, str]) -> None:
    normals = SPHERE.vertices / np.linalg.norm(SPHERE.vertices, axis=1, keepdims=True)
    levels = np.random.default_rng(0).integers(0, 65536, size=normals.shape)
    channels = dict(zip(("red", "green", "blue"), levels.T, strict=True))
    given = dict(zip(names, normals.T, strict=True)) | channels
    found = read_las(written(SPHERE.vertices, compressed=True, **given))
    assert found.normals is not None
    np.testing.assert_allclose(found.normals, normals)
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, levels / 65535.0)
    octets = {name: values // 256 for name, values in channels.items()}
    found = read_las(written(SPHERE.vertices, **octets))
    assert found.colors is not None
    np.testing.assert_allclose(found.colors, (levels // 256) / 255.0)


def test_a_surface_is_made_of_the_points() -> None:
    data = written(SPHERE.vertices, compressed=True)
    mesh = read_mesh(data, "laz")
    text = "\n".join(" ".join(map(repr, row)) for row in read_las(data).vertices.tolist())
    expected = read_mesh(text.encode(), "xyz")
    assert mesh.is_cloud
    np.testing.assert_array_equal(mesh.vertices, expected.vertices)
    np.testing.assert_array_equal(mesh.faces, expected.faces)


@pytest.mark.parametrize("file_type", ["las", "laz"])
def test_points_in_an_archive(file_type: str) -> None:
    data = written(SPHERE.vertices, compressed=file_type == "laz")
    archive = zipped({f"scan/points.{file_type}": data, "scan/notes.txt": b"x", "a.csv": b"1,2"})
    mesh = read_mesh(archive, "zip")
    assert mesh.is_cloud
    np.testing.assert_array_equal(mesh.vertices, read_mesh(data, file_type).vertices)


@pytest.mark.parametrize("compressed", [False, True])
def test_files_that_are_cut_off_are_refused(compressed: bool) -> None:
    data = written(SPHERE.vertices, compressed=compressed)
    for size in (0, 3, 100, 227, len(data) // 2, len(data) - 15):
        with pytest.raises(MeshError):
            read_mesh(data[:size], "las")


def test_files_that_promise_too_much_are_refused() -> None:
    data = bytearray(written(SPHERE.vertices, compressed=True))
    data[107:111] = (2**32 - 1).to_bytes(4, "little")
    with pytest.raises(MeshError, match="thin them out"):
        read_las(bytes(data))
    with pytest.raises(MeshError, match="no points"):
        read_las(empty())


def test_more_records_than_the_file_can_hold_are_refused_before_they_are_read() -> None:
    with pytest.raises(MeshError, match="4294967295 variable length records"):
        read_las(b"LASF" + b"\xff" * 400)
    plain, extended = (bytearray(written(SPHERE.vertices, version="1.4")) for _ in range(2))
    plain[100:104] = (2**20).to_bytes(4, "little")
    extended[243:247] = (2**20).to_bytes(4, "little")
    for data in plain, extended:
        with pytest.raises(MeshError, match="1048576 variable length records"):
            read_las(bytes(data))


@pytest.mark.parametrize("size", [1, 2, 7])
def test_damaged_sizes_of_chunks_are_refused(size: int) -> None:
    data = bytearray(written(SPHERE.vertices, compressed=True))
    at = laszip_record(data) + 12
    data[at : at + 4] = size.to_bytes(4, "little")
    with pytest.raises(MeshError, match="not a LAS file, or a damaged one"):
        read_las(bytes(data))


def test_chunks_larger_than_the_file_do_not_end_the_process() -> None:
    data = bytearray(written(SPHERE.vertices, compressed=True))
    whole = read_las(bytes(data))
    at = laszip_record(data) + 12
    data[at : at + 4] = (2**32 - 2).to_bytes(4, "little")
    np.testing.assert_array_equal(read_las(bytes(data)).vertices, whole.vertices)


@pytest.mark.parametrize("at_the_end", [False, True])
def test_more_chunks_than_the_file_can_hold_are_refused(at_the_end: bool) -> None:
    data = bytearray(written(SPHERE.vertices, compressed=True))
    start = int.from_bytes(data[96:100], "little")
    table = int.from_bytes(data[start : start + 8], "little")
    data[table + 4 : table + 8] = (2**32 - 1).to_bytes(4, "little")
    if at_the_end:
        data[start : start + 8] = (-1).to_bytes(8, "little", signed=True)
        data += table.to_bytes(8, "little")
    with pytest.raises(MeshError, match="4294967295 chunks"):
        read_las(bytes(data))


def test_a_panic_of_the_decompressor_is_an_error() -> None:
    data = bytearray(written(SPHERE.vertices, compressed=True))
    first_item = laszip_record(data) + 34
    data[first_item + 2 : first_item + 4] = (19).to_bytes(2, "little")
    with pytest.raises(MeshError, match="not a LAS file, or a damaged one"):
        read_las(bytes(data))


def test_a_header_of_an_unknown_version_is_refused() -> None:
    data = bytearray(written(SPHERE.vertices))
    data[24:26] = 9, 9
    with pytest.raises(MeshError, match="not a LAS file, or a damaged one"):
        read_mesh(bytes(data), "las")


def laszip_record(data: bytearray) -> int:
    """Place of the record with the sizes of chunks and of the parts of a point."""
    return data.find(b"laszip encoded") + 52


def empty() -> bytes:
    stream = io.BytesIO()
    laspy.LasData(laspy.LasHeader(point_format=0, version="1.2")).write(stream)
    return stream.getvalue()
