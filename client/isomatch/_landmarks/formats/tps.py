"""TPS files of geometric morphometrics (Rohlf), ``.tps``: several specimens, numbered landmarks.

``LM3=n`` is followed by n rows of coordinates, ``ID=`` names the specimen, ``SCALE=`` multiplies
its coordinates. Curves and outlines are passed over.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

from isomatch._landmarks.formats.reading import (
    FormatError,
    lines_of,
    number,
    one_line,
    position,
    whole_number,
)
from isomatch._landmarks.landmark_set import LandmarkSet

MOST_LANDMARKS: Final = 100_000
"""Greatest number of landmarks of a specimen."""

_POINT_COUNTS: Final = frozenset({"POINTS", "POINTS3", "CHAINS"})
"""Keys that are followed by as many rows of points of a curve or an outline."""


@dataclass
class _Specimen:
    """What is read of a specimen."""

    places: list[tuple[float, ...] | None]
    scale: float = 1.0
    names: dict[str, str] = field(default_factory=dict)

    def landmarks(self) -> LandmarkSet:
        rows = [
            (str(index + 1), None if place is None else [self.scale * one for one in place])
            for index, place in enumerate(self.places)
        ]
        return LandmarkSet.of(rows, self.names.get("ID") or self.names.get("IMAGE", ""))


def read(text: str) -> tuple[LandmarkSet, ...]:
    """Read a file; landmarks of NA, or of -1 in all coordinates, are missing.

    Parameters
    ----------
    text
        Of the file. Coordinates are those of the mesh.

    Raises
    ------
    FormatError
        It is no such file, or its landmarks have two coordinates; with the line.
    """
    lines = lines_of(text)
    found: list[_Specimen] = []
    place = 0
    while place < len(lines):
        content, line = lines[place].strip(), place + 1
        place += 1
        if not content:
            continue
        key, equals, value = content.partition("=")
        key = key.strip().upper()
        if not equals:
            raise FormatError(f"{content[:40]!r} is not of the form KEY=VALUE", line)
        if key in ("LM", "LM3"):
            count = whole_number(value, line, MOST_LANDMARKS)
            found.append(_Specimen(_rows(lines, place, count)))
            place += count
        elif key in _POINT_COUNTS:
            place += whole_number(value, line, len(lines))
        elif not found:
            raise FormatError(f"{key[:20]} comes before LM3=", line)
        elif key == "SCALE":
            found[-1].scale = number(value, line)
            if found[-1].scale <= 0.0:
                raise FormatError("the scale is not greater than 0", line)
        else:
            found[-1].names[key] = value.strip()
    return tuple(one.landmarks() for one in found)


def write(specimens: Iterable[LandmarkSet]) -> str:
    """Return the landmarks of specimens as a file; a landmark that is missing is NA NA NA."""
    lines = []
    for one in specimens:
        lines.append(f"LM3={len(one)}")
        lines += [" ".join(row) for row in rows_of(one)]
        lines.append(f"ID={one_line(one.name)}")
    return "".join(f"{line}\n" for line in lines)


def rows_of(landmarks: LandmarkSet) -> list[Sequence[str]]:
    """Return the coordinates of landmarks as text, NA where one is missing."""
    return [
        tuple(map(repr, place)) if there else ("NA",) * 3
        for place, there in zip(
            landmarks.positions.tolist(), landmarks.present.tolist(), strict=True
        )
    ]


def _rows(lines: list[str], start: int, count: int) -> list[tuple[float, ...] | None]:
    if start + count > len(lines):
        raise FormatError(f"the file ends before the last of {count} landmarks", len(lines))
    places = []
    for line, content in enumerate(lines[start : start + count], start=start + 1):
        texts = content.split()
        if len(texts) == 2:
            raise FormatError("two coordinates: landmarks of a surface have three (LM3=)", line)
        if len(texts) != 3:
            raise FormatError(f"{content.strip()[:40]!r} is not three coordinates", line)
        place = position(texts, line)
        places.append(None if place == (-1.0, -1.0, -1.0) else place)
    return places
