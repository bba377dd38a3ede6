"""Output of ``isomatch landmarks``: a file for each specimen, and one table of all."""

import csv
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

from isomatch._landmarks import (
    PER_SPECIMEN,
    CarriedLandmarks,
    CoordinateSystem,
    LandmarkFormat,
    append_landmarks,
    write_landmarks,
)

TABLE: Final = "landmarks.csv"
"""Name of the table in the folder."""

_MEASURES: Final = ("confidence", "round_trip", "distortion", "spread", "from_surface")


@dataclass
class LandmarkOutput:
    """Files of landmarks in a folder, complete after each specimen.

    Attributes
    ----------
    folder
        Where they are written.
    file_format
        Of the landmarks.
    coordinates
        Coordinate system of the meshes.
    found
        Landmarks so far, by the specimen's name.
    """

    folder: Path
    file_format: LandmarkFormat
    coordinates: CoordinateSystem
    found: dict[str, CarriedLandmarks] = field(default_factory=dict)

    @staticmethod
    def files(names: Iterable[str], file_format: LandmarkFormat) -> list[str]:
        """Return the names of the files of landmarks of specimens, in the folder."""
        each = (*names,) if file_format in PER_SPECIMEN else ("landmarks",)
        return [f"{name}.{file_format}" for name in each]

    def outdated(self, failed: Iterable[str]) -> list[Path]:
        """Return files of an earlier run, which failed specimens have left as they were."""
        one_each = self.file_format in PER_SPECIMEN
        names = self.files(failed, self.file_format) if one_each or not self.found else []
        if not self.found:
            names = [*names, TABLE]
        return [self.folder / name for name in names if (self.folder / name).is_file()]

    def add(self, name: str, landmarks: CarriedLandmarks) -> None:
        """Write the landmarks of a specimen, and append them to the files of all specimens."""
        first = not self.found
        self.found[name] = landmarks
        (file_name,) = self.files([name], self.file_format)
        path, specimen = self.folder / file_name, landmarks.landmark_set(name)
        if first or self.file_format in PER_SPECIMEN:
            write_landmarks(path, [specimen], self.coordinates)
        else:
            append_landmarks(path, specimen)
        mode = "w" if first else "a"
        with (self.folder / TABLE).open(mode, encoding="utf-8", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            if first:
                rows.writerow(("specimen", "label", "x", "y", "z", *_MEASURES))
            rows.writerows((name, *row.values()) for row in _rows(landmarks))


def document_of(name: str, landmarks: CarriedLandmarks) -> str:
    """Return the landmarks of a specimen as a JSON document."""
    return json.dumps({"specimen": name, "landmarks": _rows(landmarks)}, allow_nan=False)


def print_landmarks(found: Mapping[str, CarriedLandmarks], console: Console) -> None:
    """Print a row for each specimen: how many landmarks, how sure, and which is least so."""
    heads = ("landmarks", "missing", "mean confidence")
    columns = (Column(head, justify="right") for head in heads)
    last = Column("least confidence")
    table = Table(Column("specimen"), *columns, last, box=SIMPLE_HEAD, pad_edge=False)
    for name, one in found.items():
        there = np.flatnonzero(~np.isnan(one.confidence))
        missing = len(one.labels) - len(there)
        row = [name, str(len(there)), str(missing), "", ""]
        if len(there):
            least = int(there[one.confidence[there].argmin()])
            mean = one.confidence[there].mean()
            row[3:] = [f"{mean:.2f}", f"{one.confidence[least]:.2f} at {one.labels[least]}"]
        table.add_row(*map(Text, row))
    console.print(table)


def _rows(landmarks: CarriedLandmarks) -> list[dict[str, Any]]:
    """A row for each landmark; None stands for what is missing."""
    rows = []
    for place, label in enumerate(landmarks.labels):
        named: dict[str, Any] = {"label": label}
        named |= zip("xyz", landmarks.positions[place].tolist(), strict=True)
        named |= {name: float(getattr(landmarks, name)[place]) for name in _MEASURES}
        rows.append({key: None if value != value else value for key, value in named.items()})
    return rows
