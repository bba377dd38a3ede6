"""Files and folders that commands write: checked before anything is sent."""

import os
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import Final

import typer

from isomatch._operations.result_files import check_format
from isomatch._operations.results import ENDINGS

_SEPARATORS: Final = ("/", os.sep)
"""Ends of the names of folders."""


def file_named(given: str) -> Path:
    """Return the path of a file; refuse the name of a folder, and "-"."""
    if given.endswith(_SEPARATORS):
        raise typer.BadParameter(f"{given!r} is a folder; name a file")
    return Path(given)


def names_folder(given: str) -> bool:
    """Return whether a path ends like a folder's, or is one that exists."""
    return given.endswith(_SEPARATORS) or Path(given).is_dir()


def writable(given: Path | None) -> Path | None:
    """Return the name of a file to write, if its folder exists: checked before the work."""
    if given is not None:
        _refuse_dash(given)
    if given is not None and not given.parent.is_dir():
        raise typer.BadParameter(f"there is no folder {str(given.parent)!r}")
    if given is not None and given.is_dir():
        raise typer.BadParameter(f"{str(given)!r} is a folder")
    return None if given is None else _permitted(given)


def _refuse_dash(given: Path) -> None:
    if str(given) == "-":
        raise typer.BadParameter(
            "the standard output takes no files: use --json for a result as JSON there, or name a"
            " file"
        )


def _permitted(given: Path) -> Path:
    """Refuse a file or a folder that cannot be written, or made."""
    found = given.resolve()
    try:
        # Permissions do not tell: root has all, and /proc takes no files.
        if found.is_dir():
            with TemporaryFile(dir=found):
                pass
        elif found.is_file():
            with found.open("ab"):
                pass
        elif not found.exists():
            found.touch(exist_ok=False)
            found.unlink()
    except OSError as error:
        raise typer.BadParameter(f"{str(given)!r} cannot be written: {error.strerror}") from error
    return given


def output_given(given: Path | None, formats: Sequence[str] = ENDINGS) -> Path | None:
    """Return the file of ``--output``, which is a file only with some arguments."""
    with _of_option("--output"):
        return of_formats(writable(given), formats)


@contextmanager
def _of_option(name: str) -> Iterator[None]:
    try:
        yield
    except typer.BadParameter as error:
        error.param_hint = name
        raise


def picture_given(given: Path | None) -> Path | None:
    """Return the name of a PNG file to write; see :func:`writable`."""
    if given is not None and given.suffix.lower() != ".png":
        raise typer.BadParameter(f"pictures are PNG files: {given.stem}.png")
    return writable(given)


def registered_given(given: Path | None) -> Path | None:
    """Return the name of a file of a registered surface; see :func:`writable`."""
    if given is not None and given.suffix.lower() not in (".ply", ".obj", ".glb"):
        raise typer.BadParameter(f"registered surfaces are PLY, OBJ or GLB files: {given.stem}.ply")
    return writable(given)


def folder_given(given: Path) -> Path:
    """Refuse a file, a folder that cannot be written, and one in a folder that does not exist."""
    _refuse_dash(given)
    if given.exists() and not given.is_dir():
        raise typer.BadParameter(f"{str(given)!r} is not a folder")
    if not given.parent.is_dir():
        raise typer.BadParameter(f"there is no folder {str(given.parent)!r}")
    return _permitted(given)


def output_folder_given(given: Path) -> Path:
    """Return the folder of ``--output``, which is a folder only with some arguments."""
    with _of_option("--output"):
        return folder_given(given)


def files_given(folder: Path, names: Iterable[str], inputs: Collection[str | Path]) -> None:
    """Refuse names of files of a folder, which may be missing, that cannot or must not be written.

    Parameters
    ----------
    folder
        Where they are written.
    names
        Their names.
    inputs
        Files that the command reads, among others: they must not be overwritten.
    """
    if folder.is_dir():
        with _of_option("--output"):
            for name in names:
                writable(folder / name)
                _no_input(folder / name, inputs)


def _no_input(file: Path, inputs: Collection[str | Path]) -> None:
    """Refuse to write a file that the command reads, whichever name or link leads to it."""
    if file.exists() and any(Path(one).is_file() and file.samefile(one) for one in inputs):
        raise typer.BadParameter(
            f"{str(file)!r} is read by this command, and would be overwritten; choose another name"
            " or folder"
        )


def of_formats(file: Path | None, formats: Sequence[str]) -> Path | None:
    """Refuse an ending that this result is not written with; without one it is JSON."""
    try:
        if file is not None:
            check_format(file, formats)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    return file


def check_outputs(
    inputs: Collection[str | Path], wait: bool, output: Path | None, picture: Path | None = None
) -> None:
    """Refuse files of a result that is not awaited, and those that are read.

    Raises
    ------
    typer.BadParameter
        There is one; the message says what to do.
    """
    for name, file in (("--output", output), ("--picture", picture)):
        if file is not None and not wait:
            raise typer.BadParameter(
                "with --no-wait there is no result to write; leave it out, and use `isomatch jobs"
                f" result ID {name} {file.name}` later (of several targets, with ID-1, ID-2, ...)",
                param_hint=name,
            )
        if file is not None:
            with _of_option(name):
                _no_input(file, inputs)
