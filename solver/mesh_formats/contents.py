"""What every mesh format comes down to, and the operations readers share."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError


@dataclass(frozen=True, eq=False)
class FileContents:
    """Vertices and triangles as a file holds them, not yet checked or repaired.

    Parameters
    ----------
    vertices
        (V, 3).
    faces
        (F, 3) indices of vertices; polygons are cut into triangles already.
    colors
        (V, 3) in 0..1, or ``None``.
    vertex_ids
        (V,) number of each vertex in the file, from 0.
    notes
        What was changed in reading, in sentences for the user.
    """

    vertices: FloatArray
    faces: IntArray
    colors: FloatArray | None
    vertex_ids: IntArray
    notes: tuple[str, ...] = ()


def polygon_contents(
    vertices: FloatArray,
    sizes: IntArray,
    corners: IntArray,
    colors: FloatArray | None = None,
    notes: Sequence[str] = (),
) -> FileContents:
    """Cut polygons into fans of triangles.

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
        Sentences to hand on.

    Raises
    ------
    MeshError
        A polygon has fewer than three corners, or names a vertex that does not exist.
    """
    if len(sizes) and sizes.min() < 3:
        raise MeshError(
            f"face {int(np.argmax(sizes < 3))} has {sizes.min()} corners; a face needs at least 3"
        )
    check_indices(corners, len(vertices))
    notes = list(notes)
    polygons = int((sizes > 3).sum())
    if polygons:
        notes.append(f"{polygons} faces of more than three corners were cut into triangles")
    fans = sizes - 2
    first = np.repeat(np.cumsum(sizes) - sizes, fans)
    step = np.arange(fans.sum()) - np.repeat(np.cumsum(fans) - fans, fans)
    triangles = np.stack([first, first + step + 1, first + step + 2], axis=1)
    return FileContents(
        vertices,
        corners[triangles].astype(np.int64).reshape(-1, 3),
        colors,
        np.arange(len(vertices), dtype=np.int64),
        tuple(notes),
    )


def check_indices(corners: IntArray, n_vertices: int) -> None:
    """Refuse corners that name no vertex.

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


def merge_coincident(contents: FileContents, reason: str) -> FileContents:
    """Merge vertices of exactly equal position, for formats that cannot share vertices.

    Parameters
    ----------
    contents
        What the file holds.
    reason
        Why the format repeats vertices, the beginning of the note left for the user.

    Returns
    -------
    FileContents
        Vertices in the order of their first appearance; `vertex_ids` tells where that was.
    """
    positions = contents.vertices + 0.0  # -0.0 and 0.0 are the same place
    _, first, inverse = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    kept = first[order]
    merged = len(positions) - len(kept)
    if not merged:
        return contents
    note = f"{reason}: {len(positions)} vertices were merged into {len(kept)}"
    return FileContents(
        contents.vertices[kept],
        rank[inverse.reshape(-1)][contents.faces].astype(np.int64),
        None if contents.colors is None else contents.colors[kept],
        contents.vertex_ids[kept],
        (*contents.notes, note),
    )


def colors_in_unit_range(values: FloatArray) -> FloatArray | None:
    """Bring (V, 3) colours, written as 0..1 or as 0..255, to 0..1; ``None`` for anything else."""
    if not len(values) or not np.isfinite(values).all() or values.min() < 0.0:
        return None
    if values.max() <= 1.0:
        return values
    return values / 255.0 if values.max() <= 255.0 else None
