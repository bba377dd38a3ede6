"""Templates of ``isomatch landmarks``: their files read, and checked against their surfaces."""

from pathlib import Path
from typing import Final

import numpy as np

from isomatch._cli import render
from isomatch._cli.exit_codes import leave
from isomatch._clients import Client
from isomatch._errors import WrongCoordinates
from isomatch._landmarks import (
    CoordinateSystem,
    LandmarkSet,
    read_landmarks,
    remarks_on,
    stem_of,
)
from isomatch._models import Shape

_MOST_NAMED: Final = 10


def landmarks_of(file: Path, mesh: str, coordinates: CoordinateSystem) -> LandmarkSet:
    """Read the landmarks of a template; of several specimens in a file, those that bear its name.

    Parameters
    ----------
    file
        Of the landmarks.
    mesh
        Path of the template's mesh.
    coordinates
        Coordinate system of the meshes.

    Raises
    ------
    ValueError
        The file is damaged, or has no landmarks of the template.
    """
    every = read_landmarks(file, coordinates)
    name = stem_of(mesh)
    found = [one for one in every if len(every) == 1 or stem_of(one.name) == name]
    if len(found) > 1:
        raise ValueError(f"{file}: {len(found)} specimens are called {name!r}; rename all but one")
    if not found:
        others = ", ".join(repr(one.name) for one in every[:_MOST_NAMED])
        more = f" and {len(every) - _MOST_NAMED} more" if len(every) > _MOST_NAMED else ""
        raise ValueError(
            f"{file}: there is no specimen called {name!r}, only {others}{more}; name the mesh or"
            " the specimen like the other"
        )
    return found[0]


def check_template(
    client: Client,
    mesh: str,
    shape: Shape,
    landmarks: LandmarkSet,
    file: Path,
    coordinates: CoordinateSystem,
    as_json: bool,
) -> None:
    """Warn of landmarks that are far from the surface of their template.

    Exits if they cannot be carried, before anything is matched.

    Parameters
    ----------
    client
        The connection.
    mesh, shape
        Path of the template's mesh, and its upload.
    landmarks
        Of the template.
    file, coordinates
        As for :func:`landmarks_of`.
    as_json
        Report errors as JSON, and no warnings.
    """
    try:
        remarks = remarks_on(landmarks, client.geometry(shape))
    except WrongCoordinates as error:
        other: CoordinateSystem = "LPS" if coordinates == "RAS" else "RAS"
        # Files that name no system are read alike for both.
        converted = landmarks_of(file, mesh, other).positions
        same = np.array_equal(landmarks.positions, converted, equal_nan=True)
        advice = f"negate x and y in {file}" if same else f"give --coordinates {other}"
        leave(WrongCoordinates(f"{error}; {advice}"), as_json, mesh)
    except ValueError as error:
        leave(error, as_json, mesh)
    if not as_json:
        render.print_warnings([f"{mesh}: {text}" for text in remarks], render.standard_error())
