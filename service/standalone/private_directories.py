"""Directories that other users of the machine cannot read."""

from contextlib import suppress
from pathlib import Path


def close_to_others(directory: Path) -> None:
    """Close a directory to other users, if it is there.

    For directories of the service alone: those that the operator names may have other uses.
    """
    # Where it is somebody else's, they decide.
    with suppress(FileNotFoundError, PermissionError):
        directory.chmod(0o700)
