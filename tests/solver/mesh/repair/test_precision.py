"""Coordinates of shapes that lie far from the origin: which are coarse, and which are exact."""

import io
import struct
from typing import Any

import laspy
import numpy as np
import numpy.typing as npt
import pytest

from solver.arrays import IntArray
from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver import shapes
from tests.solver.mesh import mesh_files


def voxel_ball(radius: int) -> tuple[IntArray, IntArray]:
    """The squares between voxels inside and outside of a ball: (V, 3) corners, and (Q, 4)."""
    axis = np.arange(-radius - 1, radius + 2)
    inside = (np.stack(np.meshgrid(axis, axis, axis, indexing="ij")) ** 2).sum(axis=0) <= radius**2
    squares = []
    for along in range(3):
        across, up = np.eye(3, dtype=np.int64)[[(along + 1) % 3, (along + 2) % 3]]
        for side in (0, 1):
            found = np.argwhere(inside & ~np.roll(inside, 1 - 2 * side, along))
            found[:, along] += side
            corners = np.stack([found, found + across, found + across + up, found + up], axis=1)
            squares.append(corners if side else corners[:, ::-1])
    points, numbers = np.unique(np.concatenate(squares).reshape(-1, 3), axis=0, return_inverse=True)
    return points, numbers.reshape(-1, 4)


POINTS, SQUARES = voxel_ball(6)
EXTENT = int(np.ptp(POINTS))


def integer_ply(points: IntArray, binary: bool) -> bytes:
    if binary:
        rows = np.zeros(len(SQUARES), [("size", "u1"), ("corners", "<i4", (4,))])
        rows["size"], rows["corners"] = 4, SQUARES
        form, body = "binary_little_endian", points.astype("<i4").tobytes() + rows.tobytes()
    else:
        lines = [*points.tolist(), *([4, *row] for row in SQUARES.tolist())]
        form, body = "ascii", "".join(" ".join(map(str, line)) + "\n" for line in lines).encode()
    header = ["ply", f"format {form} 1.0", f"element vertex {len(points)}"]
    header += [f"property int {axis}" for axis in "xyz"]
    header += [f"element face {len(SQUARES)}", "property list uchar int vertex_indices"]
    return "\n".join([*header, "end_header\n"]).encode() + body


def las(points: npt.NDArray[Any], scale: float, offset: float = 0.0) -> bytes:
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales, header.offsets = np.full(3, scale), np.full(3, offset)
    data = laspy.LasData(header)
    data.x, data.y, data.z = points.T
    stream = io.BytesIO()
    data.write(stream)
    return stream.getvalue()


@pytest.mark.parametrize("extents", [63, 66, 80, 99, 1000, 10**5])
def test_integers_are_exact_anywhere(extents: int) -> None:
    far = POINTS + extents * EXTENT
    near = read_mesh(integer_ply(POINTS, True), "ply")
    for data in (integer_ply(far, True), integer_ply(far, False)):
        found = read_mesh(data, "ply")
        np.testing.assert_array_equal(found.vertices, near.vertices + extents * EXTENT)
        np.testing.assert_array_equal(found.faces, near.faces)
        assert found.warnings == near.warnings
    for scale in (1.0, 0.5):
        cloud = read_mesh(las(scale * POINTS, scale), "las")
        moved = read_mesh(las(scale * far, scale), "las")
        assert moved.warnings == cloud.warnings
        np.testing.assert_array_equal(moved.faces, cloud.faces)


@pytest.mark.parametrize("extents", [66, 1000])
def test_shapes_that_were_rounded_to_such_a_grid_are_refused(extents: int) -> None:
    ball = shapes.icosphere(3)
    edge = float(np.median(np.linalg.norm(np.diff(ball.vertices[ball.faces], axis=1), axis=2)))
    for grids in (1.0, 1.5):  # of the grid in an edge
        points = np.rint(ball.vertices / (grids * edge))
        points += extents * np.ptp(points)
        with pytest.raises(MeshError, match="its details are lost; move it to the origin"):
            read_mesh(mesh_files.ply(points, ball.faces.tolist()), "ply")
        with pytest.raises(MeshError, match="its details are lost"):
            read_mesh("".join(f"{x} {y} {z}\n" for x, y, z in points.tolist()).encode(), "xyz")
        with pytest.raises(MeshError, match="its details are lost"):
            read_mesh(mesh_files.stl(points, ball.faces), "stl")


def test_an_offset_that_double_precision_cannot_hold_is_refused() -> None:
    with pytest.raises(MeshError, match="its details are lost"):
        read_mesh(las(1e-3 * POINTS + 1e13, 1e-3, offset=1e13), "las")


def test_coordinates_whose_sum_is_infinite_are_refused() -> None:
    points = shapes.icosphere(2).vertices + np.array([1e308, 0.0, 0.0])
    rows = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
    with pytest.raises(MeshError, match="too large or too small"):
        read_mesh(rows.encode(), "xyz")
    data = bytearray(las(POINTS, 1.0))
    data[155:163] = struct.pack("<d", 1e308)  # offset of x
    with pytest.raises(MeshError, match="too large or too small"):
        read_mesh(bytes(data), "las")
