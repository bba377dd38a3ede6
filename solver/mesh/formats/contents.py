"""Operations shared by the readers of all formats: polygons, indices, colours."""

from collections.abc import Sequence

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.repair import (
    TriangleSoup,
    check_coordinates,
    counted,
    triangulated,
)


def polygon_contents(
    vertices: FloatArray,
    sizes: IntArray,
    corners: IntArray,
    colors: FloatArray | None = None,
    notes: Sequence[str] = (),
) -> TriangleSoup:
    """Cut polygons into triangles.

    Parameters
    ----------
    vertices
        (V, 3).
    sizes
        (P,) number of corners of each polygon.
    corners
        (sum of `sizes`,) vertex indices of the polygons, one after the other.
    colors
        (V, 3) in 0..1, or ``None``.
    notes
        Sentences for the user.

    Raises
    ------
    MeshError
        A polygon has fewer than three corners or too many, or uses a vertex that does not exist
        or has coordinates that are not finite.
    """
    if len(sizes) and sizes.min() < 3:
        raise MeshError(
            f"face {int(np.argmax(sizes < 3))} has {sizes.min()} corners; a face needs at least 3"
        )
    check_indices(corners, len(vertices))
    if len(corners):
        check_coordinates(vertices, corners)
    cut = triangulated(vertices, sizes, corners)
    notes = list(notes)
    polygons = int((sizes > 3).sum())
    if polygons:
        notes.append(f"cut {counted(polygons, 'face')} of more than three corners into triangles")
    if cut.crossed:
        notes.append(
            f"{counted(cut.crossed, 'face')} whose outline crosses itself: the triangles overlap"
        )
    return TriangleSoup(
        vertices,
        cut.triangles,
        colors,
        np.arange(len(vertices), dtype=np.int64),
        np.repeat(np.arange(len(sizes), dtype=np.int64), sizes - 2),
        tuple(notes),
    )


def check_indices(corners: IntArray, n_vertices: int) -> None:
    """Refuse indices of vertices that do not exist.

    Raises
    ------
    MeshError
        An index is negative or too large.
    """
    if len(corners) and (corners.min() < 0 or corners.max() >= n_vertices):
        wrong = corners[(corners < 0) | (corners >= n_vertices)][0]
        raise MeshError(
            f"a face refers to vertex {wrong}, counted from 0, but the file has {n_vertices} "
            "vertices; the file is cut off or damaged"
        )


def colors_in_unit_range(values: FloatArray) -> FloatArray | None:
    """Bring (V, 3) colours, written as 0..1 or as 0..255, to 0..1; ``None`` for anything else."""
    if not len(values) or not np.isfinite(values).all() or values.min() < 0.0:
        return None
    if values.max() <= 1.0:
        return values
    return values / 255.0 if values.max() <= 255.0 else None
