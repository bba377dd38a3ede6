"""The dissimilarities that are known while a collection is still compared."""

import gzip
import io
import json
import sys
from array import array
from collections.abc import Iterable, Mapping
from itertools import combinations, islice

Matrix = list[list[float | None]]


def number_of_pairs(count: int) -> int:
    """Return how many unordered pairs of so many shapes there are."""
    return count * (count - 1) // 2


def known_matrix(count: int, size: int, parts: Iterable[tuple[int, bytes]]) -> tuple[Matrix, int]:
    """Put parts of the pairs into a matrix.

    Parameters
    ----------
    count
        Number K of shapes.
    size
        Pairs of a part; the pairs i < j are in lexicographic order.
    parts
        Number of each part that is done, and its dissimilarities, float64, little end first.

    Returns
    -------
    matrix, done
        K rows of K, None for what is not known, and how many pairs are.
    """
    matrix: Matrix = [[None] * count for _ in range(count)]
    for place, row in enumerate(matrix):
        row[place] = 0.0
    known = {number * size: _numbers(data) for number, data in parts}
    # One walk over the pairs, from part to part.
    pairs, place = combinations(range(count), 2), 0
    for first in sorted(known):
        values = known[first]
        next(islice(pairs, first - place, first - place), None)
        for (i, j), value in zip(islice(pairs, len(values)), values, strict=True):
            matrix[i][j] = matrix[j][i] = value
        place = first + len(values)
    return matrix, sum(map(len, known.values()))


def packed_document(fields: Mapping[str, object], matrix: Matrix) -> bytes:
    """Return a document with a matrix, JSON in gzip.

    Parameters
    ----------
    fields
        The other fields, at least one.
    matrix
        The field ``matrix``.
    """
    packed = io.BytesIO()
    with gzip.GzipFile(fileobj=packed, mode="wb", compresslevel=1, mtime=0) as file:
        file.write(f'{_json(fields)[:-1]},"matrix":['.encode())
        # A row at a time: other threads wait for `dumps`, and a matrix may take seconds.
        for place, row in enumerate(matrix):
            file.write(f"{',' if place else ''}{_json(row)}".encode())
        file.write(b"]}")
    return packed.getvalue()


def _json(value: object) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


def _numbers(data: bytes) -> "array[float]":
    numbers = array("d", data)
    if sys.byteorder == "big":
        numbers.byteswap()
    return numbers
