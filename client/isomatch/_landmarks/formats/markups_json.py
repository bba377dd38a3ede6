"""Markups of 3D Slicer, ``.mrk.json``.

https://slicer.readthedocs.io/en/latest/developer_guide/modules/markups.html has the format and its
schema. The control points of all markups of a file are taken, one list after the other.
"""

import json
from collections.abc import Sequence
from typing import Any, Final

from isomatch._landmarks.formats.reading import CoordinateSystem, FormatError, coordinate_system
from isomatch._landmarks.landmark_set import LandmarkSet

_SCHEMA: Final = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/"
    "Schema/markups-schema-v1.0.3.json#"
)
_STATES: Final = ("defined", "undefined", "preview", "missing")


def read(text: str, coordinates: CoordinateSystem) -> tuple[LandmarkSet, ...]:
    """Read a file.

    Points whose `positionStatus` is not "defined" are missing.

    Parameters
    ----------
    text
        Of the file.
    coordinates
        Coordinate system of the mesh; positions are converted to it.

    Raises
    ------
    FormatError
        It is no such file.
    """
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", error.lineno) from error
    except (RecursionError, ValueError) as error:
        raise FormatError(f"not usable as JSON: {error}") from error
    markups = _list(document, "markups", "the file")
    if not markups:
        raise FormatError("`markups` is empty")
    rows: list[tuple[str, Sequence[float] | None]] = []
    remarks: list[str] = []
    for place, markup in enumerate(markups):
        where = f"markups[{place}]"
        points = _list(markup, "controlPoints", where)
        system = coordinate_system(str(markup.get("coordinateSystem", "LPS")))
        sign = 1.0 if system == coordinates else -1.0
        for index, point in enumerate(points):
            row, remark = _point(point, f"{where}.controlPoints[{index}]", sign)
            rows.append((row[0] or str(len(rows) + 1), row[1]))
            remarks.append(remark)
    name = markups[0].get("name", "")
    return (LandmarkSet.of(rows, name if isinstance(name, str) else "", tuple(remarks)),)


def write(landmarks: LandmarkSet, coordinates: CoordinateSystem) -> str:
    """Return landmarks as a file.

    Parameters
    ----------
    landmarks
        The landmarks.
    coordinates
        Coordinate system of their positions.
    """
    remarks = landmarks.descriptions or ("",) * len(landmarks)
    places = zip(landmarks.labels, landmarks.positions.tolist(), remarks, strict=True)
    present = landmarks.present.tolist()
    points = [
        {
            "id": str(index + 1),
            "label": label,
            "description": remark,
            "associatedNodeID": "",
            "position": place if present[index] else [0.0, 0.0, 0.0],
            "selected": True,
            "locked": False,
            "visibility": present[index],
            "positionStatus": "defined" if present[index] else "missing",
        }
        for index, (label, place, remark) in enumerate(places)
    ]
    markup = {
        "name": landmarks.name,
        "type": "Fiducial",
        "coordinateSystem": coordinates,
        "controlPoints": points,
    }
    return json.dumps({"@schema": _SCHEMA, "markups": [markup]}, indent=1, allow_nan=False) + "\n"


def _point(point: Any, where: str, sign: float) -> tuple[tuple[str, Sequence[float] | None], str]:
    """Label and position of a control point, and its description."""
    if not isinstance(point, dict):
        raise FormatError(f"{where} is not an object")
    label, remark = _text(point, "label"), _text(point, "description")
    state = point.get("positionStatus", "defined")
    if state not in _STATES:
        raise FormatError(f"{where}.positionStatus is {str(state)[:20]!r}, none of {_STATES}")
    if state != "defined":
        return (label, None), remark
    place = _list(point, "position", where)
    numbers = [one for one in place if isinstance(one, int | float) and not isinstance(one, bool)]
    if len(place) != 3 or len(numbers) != 3 or not all(abs(one) < 1e300 for one in numbers):
        raise FormatError(f"{where}.position is not three finite numbers")
    x, y, z = map(float, numbers)
    return (label, (sign * x, sign * y, z)), remark


def _text(point: dict[str, Any], name: str) -> str:
    value = point.get(name)
    return "" if value is None else str(value)


def _list(document: Any, name: str, where: str) -> list[Any]:
    found = document.get(name) if isinstance(document, dict) else None
    if not isinstance(found, list):
        raise FormatError(f"{where} has no list `{name}`; is this a file of Slicer markups?")
    return found
