"""Row/column files of MorphoJ, ``.txt``: a specimen in each row, its identifier first.

Entries are delimited by commas, semicolons or tab stops. The first line may name the columns.
"""

import csv
import io
from collections.abc import Iterable

from isomatch._landmarks.formats.reading import (
    FormatError,
    is_missing,
    is_number,
    one_line,
    position,
    table,
)
from isomatch._landmarks.formats.tps import rows_of
from isomatch._landmarks.landmark_set import LandmarkSet


def read(text: str) -> tuple[LandmarkSet, ...]:
    """Read a file; landmarks whose coordinates are empty or NA are missing.

    Parameters
    ----------
    text
        Of the file. Coordinates are those of the mesh.

    Raises
    ------
    FormatError
        It is no such file; with the line.
    """
    rows = table(text)
    if len(rows) > 1 and _names_columns(rows[0][1]):
        rows = rows[1:]
    return tuple(_specimen(line, entries) for line, entries in rows)


def names_landmarks(first: list[str]) -> bool:
    """Return whether the first row of a table names the coordinates of landmark 1."""
    return {"x1", "y1", "z1"} <= {name.lower() for name in first}


def write(specimens: Iterable[LandmarkSet]) -> str:
    """Return the landmarks of specimens as a file, delimited by tab stops.

    Raises
    ------
    ValueError
        The specimens have different numbers of landmarks.
    """
    every = tuple(specimens)
    counts = sorted({len(one) for one in every})
    if len(counts) > 1:
        raise ValueError(f"the specimens have {counts[0]} to {counts[-1]} landmarks")
    names = [f"{axis}{index + 1}" for index in range(max(counts, default=0)) for axis in "xyz"]
    return "\t".join(["ID", *names]) + "\n" + "".join(map(row_of, every))


def row_of(specimen: LandmarkSet) -> str:
    """Return the line of a specimen; a name with quotation marks is quoted, as it is read."""
    out = io.StringIO()
    texts = (text for row in rows_of(specimen) for text in row)
    csv.writer(out, delimiter="\t", lineterminator="\n").writerow([one_line(specimen.name), *texts])
    return out.getvalue()


def _specimen(line: int, entries: list[str]) -> LandmarkSet:
    name, texts = entries[0], entries[1:]
    if not texts or len(texts) % 3:
        raise FormatError(
            f"{len(texts)} coordinates after the identifier are not three for each landmark", line
        )
    places = [position(texts[at : at + 3], line) for at in range(0, len(texts), 3)]
    return LandmarkSet.of([(str(index + 1), place) for index, place in enumerate(places)], name)


def _names_columns(first: list[str]) -> bool:
    """Return whether a row has no coordinates, and is none of a specimen without landmarks."""
    entries = first[1:]
    specimen = bool(entries) and all(map(is_missing, entries))
    return not specimen and not any(map(is_number, entries))
