"""Arrays as the PLY files that are uploaded."""

from typing import Final

import numpy as np
import numpy.typing as npt

from isomatch._upload.arrays import checked_arrays, checked_colors, checked_points

_NORMALS: Final = ("nx", "ny", "nz")


def points_ply(points: npt.ArrayLike, colors: npt.ArrayLike | None = None) -> bytes:
    """Write a point cloud as little-endian binary PLY, exactly and in the order given.

    Parameters
    ----------
    points
        (V, 3) positions, or (V, 6) with normals, written as float64.
    colors
        As for :func:`binary_ply`.

    Raises
    ------
    ValueError
        An array is invalid: see :func:`checked_points` and :func:`checked_colors`.
    """
    table = checked_points(points)
    normals = _NORMALS if table.shape[1] > 3 else ()
    rows, properties = _vertex_rows(table, normals, colors)
    return _header(f"element vertex {len(table)}", *properties) + rows


def binary_ply(
    vertices: npt.ArrayLike, faces: npt.ArrayLike, colors: npt.ArrayLike | None = None
) -> bytes:
    """Write a triangle mesh as little-endian binary PLY, exactly and in the order given.

    Parameters
    ----------
    vertices
        Positions, (V, 3), written as float64.
    faces
        Vertex indices from 0, (F, 3).
    colors
        RGB or RGBA of each vertex, (V, 3) or (V, 4), integers from 0 to 255 or floats from 0 to 1;
        alpha is ignored.

    Raises
    ------
    ValueError
        An array is invalid: see :func:`checked_arrays` and :func:`checked_colors`.
    """
    points, triangles = checked_arrays(vertices, faces)
    rows, properties = _vertex_rows(points, (), colors)
    face_table = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    face_table["count"] = 3
    face_table["corners"] = triangles
    header = _header(
        f"element vertex {len(points)}",
        *properties,
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
    )
    return header + rows + face_table.tobytes()


def _vertex_rows(
    numbers: npt.NDArray[np.float64], normals: tuple[str, ...], colors: npt.ArrayLike | None
) -> tuple[bytes, list[str]]:
    """Rows of the vertices, and their properties."""
    fields: list[tuple[str, str, tuple[int, ...]]] = [("numbers", "<f8", (numbers.shape[1],))]
    properties = [f"property double {name}" for name in ("x", "y", "z", *normals)]
    if colors is not None:
        fields.append(("color", "u1", (3,)))
        properties += [f"property uchar {channel}" for channel in ("red", "green", "blue")]
    table = np.empty(len(numbers), dtype=fields)
    table["numbers"] = numbers
    if colors is not None:
        table["color"] = checked_colors(colors, len(numbers))
    return table.tobytes(), properties


def _header(*lines: str) -> bytes:
    return "\n".join(["ply", "format binary_little_endian 1.0", *lines, "end_header\n"]).encode()
