"""Formats that results are written in, by which files are refused before a job runs."""

import errno
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from isomatch._results import TransferKind

SURFACES: Final = ("ply", "obj", "glb")
"""Formats of surfaces; of a match they show its map of all vertices."""

MATCH_FORMATS: Final = ("npz", "csv", *SURFACES, "png")
"""Formats of the result of a single match, besides JSON."""

COMPARE_FORMATS: Final = ("npz", "csv", "png")
"""Formats of dissimilarities, besides JSON."""

TRANSFER_FORMATS: Final[Mapping[TransferKind, tuple[str, ...]]] = {
    "scalars": ("npz", "csv", "ply", "glb"),
    "vectors": ("npz", "csv", "ply", "glb"),
    "colors": ("npz", "csv", "ply", "obj", "glb"),
    "labels": ("npz", "csv", "ply", "obj", "glb"),
    "skinning": ("npz", "csv", "ply", "glb"),
    "landmarks": ("npz", "csv"),
    "texture": ("npz", "csv", "ply", "obj", "glb", "zip"),
    "uv": ("npz", "csv", "obj", "glb", "zip"),
}
"""Formats that hold what is carried, besides JSON."""


def check_format(file: Path, formats: Sequence[str]) -> None:
    """Refuse an ending that a result is not written with; without one it is JSON.

    Parameters
    ----------
    file
        The file to write.
    formats
        Formats of the result besides JSON.

    Raises
    ------
    ValueError
        It is in none of them.
    """
    ending = file.suffix.lower()
    endings = [f".{name}" for name in dict.fromkeys(("json", *formats))]
    if ending and ending not in endings:
        given = " or ".join(", ".join(endings).rsplit(", ", 1))
        raise ValueError(f"this result has no {ending} file: give {given}")


def check_folder(path: str | os.PathLike[str]) -> None:
    """Refuse a file in a folder that does not exist, before its contents are requested.

    Raises
    ------
    FileNotFoundError
        There is no such folder.
    """
    folder = Path(path).parent
    if not folder.is_dir():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(folder))


def shows_dense_map(file: Path) -> bool:
    """Return whether a file of a match shows its map of all vertices."""
    return file.suffix.lower().removeprefix(".") in SURFACES
