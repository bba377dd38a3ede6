"""Transfer of arrays along a dense match, computed locally."""

from typing import Any, Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from isomatch._models import DenseCorrespondence, VertexMap
from isomatch._results.array_labels import as_labels

TransferKind: TypeAlias = Literal[
    "scalars", "vectors", "colors", "labels", "skinning", "landmarks", "texture", "uv"
]
"""Kind of what is carried."""

Direction: TypeAlias = Literal["source_to_target", "target_to_source"]
"""From which shape to which values are carried."""

Element: TypeAlias = Literal["vertices", "faces"]
"""What of a shape takes values."""

ARRAY_KINDS: Final = ("scalars", "vectors", "colors", "labels", "skinning", "landmarks")
"""Kinds of arrays of vertices."""

KINDS: Final = (*ARRAY_KINDS, "texture", "uv")
"""All kinds; texture and texture coordinates are in a file, and carried by the service."""


def goes_forwards(direction: Direction) -> bool:
    """Return whether a direction is from source to target.

    Raises
    ------
    ValueError
        It is no direction.
    """
    if direction not in ("source_to_target", "target_to_source"):
        raise ValueError(
            f"direction is 'source_to_target' or 'target_to_source', not {direction!r}"
        )
    return direction == "source_to_target"


def transferred(
    dense: DenseCorrespondence,
    values: npt.ArrayLike,
    kind: TransferKind,
    direction: Direction,
    influences: int | None,
    name: str,
    rows: int | None,
    others: int | None,
) -> npt.NDArray[Any]:
    """Carry values from one shape of a match to the other; see :meth:`isomatch.Match.transfer`.

    `name` is that of the shape that values are of, `rows` the number of vertices of its file, and
    `others` that of the other file; None if it is not known.
    """
    if values is None:
        raise TypeError(f"give an array with a row for each vertex of {name}, not None")
    forwards = goes_forwards(direction)
    _check_influences(influences, kind)
    if kind == "landmarks":
        map_of_points = dense.source_to_target if forwards else dense.target_to_source
        return _images(map_of_points, values, name, rows)
    if kind not in ARRAY_KINDS:
        raise ValueError(f"kind is one of {', '.join(ARRAY_KINDS)}, not {kind!r}")
    # Each vertex takes the value at its image, so the map goes the other way.
    along = dense.target_to_source if forwards else dense.source_to_target
    given = np.asarray(values)
    _check_rows(given, along, name, rows)
    if kind == "labels":
        return by_vertex(along, along.majority(as_labels(given)), others)
    numbers = given.astype(np.float64)
    if np.isinf(numbers).any():
        raise ValueError("values must not be infinite")
    if kind == "skinning":
        return by_vertex(along, _skinning(along, numbers, influences), others)
    found = by_vertex(along, _known_means(along, numbers), others)
    if kind == "colors" and given.dtype == np.uint8:
        rounded: npt.NDArray[np.uint8] = np.rint(np.nan_to_num(found)).astype(np.uint8)
        return rounded
    return found


def _check_influences(influences: int | None, kind: TransferKind) -> None:
    if influences is None:
        return
    if kind != "skinning":
        raise ValueError(f"only skinning weights have influences, not {kind!r}; leave it out")
    if influences < 1:
        raise ValueError(f"influences is at least 1, or None for all joints, not {influences}")


def _check_rows(values: npt.NDArray[Any], along: VertexMap, name: str, rows: int | None) -> None:
    """Refuse values that have not a row for each vertex of the file they are of."""
    have = len(values) if values.ndim else 0
    # Results of earlier versions do not know the rows of the file, which has at least these.
    least = int(along.faces.max(initial=-1)) + 1
    if have < least if rows is None else have != rows:
        count = f"{rows:,}" if rows is not None else f"at least {least:,}"
        raise ValueError(
            f"there are {have:,} rows of values, but {name} has {count} vertices: give a row for"
            " each, in the order of its file; Client.transfer carries values of faces"
        )


def _images(
    along: VertexMap, vertices: npt.ArrayLike, name: str, rows: int | None
) -> npt.NDArray[np.int64]:
    """Images of vertices, -1 for those without a partner."""
    wanted = np.asarray(vertices)
    if wanted.size and wanted.dtype.kind not in "iu":
        raise ValueError(f"landmarks are vertices, whole numbers, not {wanted.dtype}")
    wanted = wanted.astype(np.int64)
    image_of = by_vertex(along, along.images, rows)
    unknown = wanted[(wanted < 0) | (wanted >= len(image_of))]
    if unknown.size:
        raise ValueError(f"{unknown.flat[0]} is no vertex of {name}, which has {len(image_of):,}")
    found: npt.NDArray[np.int64] = image_of[wanted]
    return found


def _skinning(
    along: VertexMap, weights: npt.NDArray[np.float64], influences: int | None
) -> npt.NDArray[np.float64]:
    if weights.ndim != 2:
        raise ValueError(
            f"skinning weights have a column for each joint, not shape {weights.shape}"
        )
    if (weights < 0.0).any():
        raise ValueError("skinning weights must not be negative")
    means = _known_means(along, _normalised(weights))
    if influences is not None and influences < means.shape[1]:
        # Of equal weights the first joints are kept, as by the service.
        weakest = np.argsort(-means, axis=1, kind="stable")[:, influences:]
        np.put_along_axis(means, weakest, 0.0, axis=1)
    return _normalised(means)


def _known_means(along: VertexMap, values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Means of the rows without nan, nan where most of the weight is on others."""
    known = ~np.asarray(np.isnan(values).any(axis=tuple(range(1, values.ndim))))
    if known.all():
        return along.interpolate(values)
    columns = (slice(None), *[None] * (values.ndim - 1))
    shares = along.interpolate(known)[columns]
    sums = along.interpolate(np.where(known[columns], values, 0.0))
    return np.where(shares >= 0.5, sums / np.maximum(shares, 0.5), np.nan)


def _normalised(weights: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    # The greatest first, so that sums of great weights stay finite.
    scaled = weights / np.where(weights > 0.0, weights, 0.0).max(axis=1, initial=1e-300)[:, None]
    sums = scaled.sum(axis=1, keepdims=True)
    found: npt.NDArray[np.float64] = scaled / np.where(sums == 0.0, 1.0, sums)
    return found


def by_vertex(along: VertexMap, values: npt.NDArray[Any], rows: int | None) -> npt.NDArray[Any]:
    """Return row i for vertex i of the file; others than `along` has get nan, -1 or an empty text.

    Parameters
    ----------
    along
        The map of K vertices.
    values
        Of these, (K, ...).
    rows
        Number of vertices of the file; None if it is not known.
    """
    missing = {"f": np.nan, "i": -1, "U": ""}[values.dtype.kind]
    count = int(along.vertices.max(initial=-1)) + 1 if rows is None else rows
    found = np.full((count, *values.shape[1:]), missing, dtype=values.dtype)
    found[along.vertices] = values
    return found
