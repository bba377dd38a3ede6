"""The dissimilarities that are known while a collection is still compared."""

import gzip
import json
import math
import sys
from array import array
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from tempfile import SpooledTemporaryFile
from typing import BinaryIO, Final, cast

from service.http import unpacked

_MATRIX: Final = b'"matrix":[['
"""Begins the matrix of a stored result. No text has it: quotes in texts are escaped."""

_IN_MEMORY: Final = 256 * 1024
"""Bytes of a document up to which it stays in memory; a larger one goes into a temporary file."""


def number_of_pairs(count: int) -> int:
    """Return how many unordered pairs of so many shapes there are."""
    return count * (count - 1) // 2


def known_pairs(count: int, size: int, parts: Mapping[int, bytes]) -> "array[float]":
    """Return the dissimilarities of all pairs i < j in lexicographic order, NaN if not known.

    Parameters
    ----------
    count
        Number K of shapes.
    size
        Pairs of a part.
    parts
        Dissimilarities of the parts that are done, float64, little end first, by number.
    """
    values = array("d", [math.nan]) * number_of_pairs(count)
    for number, data in parts.items():
        found = _numbers(data)
        values[number * size : number * size + len(found)] = found
    return values


def written_matrix(count: int, values: "array[float]") -> Iterator[bytes]:
    """Write a matrix of dissimilarities as JSON, a row at a time.

    Parameters
    ----------
    count
        Number K of shapes.
    values
        (K(K−1)/2,) dissimilarities of all pairs, as :func:`known_pairs` returns them.
    """
    # The pair (i, j) is at bases[i] + j.
    bases = [i * (2 * count - i - 3) // 2 - 1 for i in range(count)]
    for i, base in enumerate(bases):
        earlier = [values[other + i] for other in bases[:i]]
        row = [*earlier, 0.0, *values[base + i + 1 : base + count]]
        known = [None if math.isnan(value) else value for value in row]
        yield b"," if i else b"["
        yield _json(known)
    yield b"]"


def stored_matrix(result: BinaryIO) -> Iterator[bytes]:
    """Copy the matrix from a stored result, without parsing its numbers.

    Parameters
    ----------
    result
        The result, JSON in gzip, which is closed in the end.
    """
    with result:
        content = unpacked(result)
        seen = b""
        while (start := seen.find(_MATRIX)) < 0:
            seen = seen[-len(_MATRIX) :] + next(content)
        seen = seen[start + len(_MATRIX) - 2 :]
        while (end := seen.find(b"]]")) < 0:
            yield seen[:-1]
            seen = seen[-1:] + next(content)
        yield seen[: end + 2]


def packed_document(fields: Mapping[str, object], matrix: Iterable[bytes]) -> BinaryIO:
    """Return a document with a matrix, JSON in gzip, in a temporary file where it is large.

    Parameters
    ----------
    fields
        The other fields, at least one.
    matrix
        The field ``matrix`` as JSON, in pieces.
    """
    with ExitStack() as closing:
        packed = cast(BinaryIO, closing.enter_context(SpooledTemporaryFile(max_size=_IN_MEMORY)))
        with gzip.GzipFile(fileobj=packed, mode="wb", compresslevel=1, mtime=0) as file:
            file.write(_json(fields)[:-1] + b',"matrix":')
            for piece in matrix:
                file.write(piece)
            file.write(b"}")
        packed.seek(0)
        closing.pop_all()  # the caller closes it
    return packed


def _json(value: object) -> bytes:
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode()


def _numbers(data: bytes) -> "array[float]":
    numbers = array("d", data)
    if sys.byteorder == "big":
        numbers.byteswap()
    return numbers
