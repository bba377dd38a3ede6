"""Reader of ``.dd`` files, the format in which graph matching instances are published.

The format has no third-order terms: its lines are assignments and pairs of these.

A file has a line ``p N M A E``, then A lines ``a ID X Y COST``, the candidates and their unary
costs, and E lines ``e A B COST``, the pairwise costs of two candidates. A source or target point
may stay without partner at no cost. Lines that begin with ``c`` or ``#``, and those of kinds that
only say where points are, are skipped. The format is that of Torresani, Kolmogorov and Rother's
programs.
"""

import bz2
import gzip
import lzma
from collections.abc import Callable
from pathlib import Path

import numpy as np

from solver.arrays import IntArray
from solver.labelling import LabellingProblem, PairwiseTerms

_DECOMPRESS: dict[str, Callable[[bytes], bytes]] = {
    ".xz": lzma.decompress,
    ".gz": gzip.decompress,
    ".bz2": bz2.decompress,
}


class FormatError(ValueError):
    """The file is not a sound ``.dd`` file; the message says where."""


def read_dd(path: Path) -> LabellingProblem:
    """Read a graph matching instance.

    Parameters
    ----------
    path
        The file, possibly compressed (``.xz``, ``.gz``, ``.bz2``).

    Returns
    -------
    problem
        Problem (5) with explicit pairwise terms and an occlusion cost of 0. Terms of candidates
        that exclude one another are left out, several of the same two candidates added up.

    Raises
    ------
    FormatError
        A line cannot be read, or the counts of the first line are wrong.
    """
    return parse_dd(read_text(path))


def read_text(path: Path) -> str:
    """Read a file's text, decompressed.

    Parameters
    ----------
    path
        The file, possibly compressed (``.xz``, ``.gz``, ``.bz2``).

    Raises
    ------
    FormatError
        It cannot be decompressed.
    """
    data = path.read_bytes()
    try:
        data = _DECOMPRESS.get(path.suffix, bytes)(data)
    except (OSError, EOFError, ValueError, lzma.LZMAError) as error:
        raise FormatError(f"{path.name} is not sound: {error}") from error
    return data.decode("ascii", "replace")


def parse_dd(text: str) -> LabellingProblem:
    """Read a graph matching instance from the text of its file; see :func:`read_dd`."""
    header: list[int] | None = None
    assignments: list[tuple[int, int, int, float]] = []
    edges: list[tuple[int, int, float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        kind, *fields = line.split() or [""]
        try:
            if kind == "p":
                if header is not None:
                    raise ValueError("a second problem line")
                header = [int(field) for field in _exactly(4, fields)]
            elif kind == "a":
                identity, x, y, cost = _exactly(4, fields)
                assignments.append((int(identity), int(x), int(y), float(cost)))
            elif kind == "e":
                a, b, cost = _exactly(3, fields)
                edges.append((int(a), int(b), float(cost)))
        except ValueError as error:
            raise FormatError(f"line {number}: {error}: {line[:60]!r}") from error
    if header is None:
        raise FormatError("there is no problem line, 'p N M A E'")
    sizes, (n_assignments, n_edges) = (header[0], header[1]), header[2:]
    if (n_assignments, n_edges) != (len(assignments), len(edges)):
        raise FormatError(
            f"the problem line announces {n_assignments} assignments and {n_edges} edges,"
            f" the file has {len(assignments)} and {len(edges)}"
        )
    return _problem(sizes, assignments, edges)


def _exactly(count: int, fields: list[str]) -> list[str]:
    if len(fields) != count:
        raise ValueError(f"{count} fields belong here, not {len(fields)}")
    return fields


def _problem(
    shape: tuple[int, int],
    assignments: list[tuple[int, int, int, float]],
    edges: list[tuple[int, int, float]],
) -> LabellingProblem:
    identity, x, y = np.array([a[:3] for a in assignments], dtype=np.int64).reshape(-1, 3).T
    unary = np.array([a[3] for a in assignments], dtype=np.float64)
    if len(np.unique(identity)) != len(identity):
        raise FormatError("two assignments have the same number")
    order = np.lexsort((y, x))
    ends = np.array([e[:2] for e in edges], dtype=np.int64).reshape(-1, 2)
    costs = np.array([e[2] for e in edges], dtype=np.float64)
    ends = _places(identity[order], ends)
    candidates = np.stack([x[order], y[order]], axis=1)
    apart = (candidates[ends[:, 0]] != candidates[ends[:, 1]]).all(axis=1)
    try:
        terms = PairwiseTerms.collect(ends[apart], costs[apart])
        return LabellingProblem.explicit(shape, candidates, unary[order], terms, 0.0)
    except ValueError as error:
        raise FormatError(str(error)) from error


def _places(identities: IntArray, wanted: IntArray) -> IntArray:
    """Place of each wanted number among some numbers."""
    if not wanted.size:
        return wanted
    if not identities.size:
        raise FormatError("an edge names an assignment, and there is none")
    order = np.argsort(identities)
    found = np.minimum(np.searchsorted(identities[order], wanted), len(identities) - 1)
    places: IntArray = order[found]
    if (identities[places] != wanted).any():
        raise FormatError("an edge names an assignment that does not exist")
    return places.astype(np.int64)
