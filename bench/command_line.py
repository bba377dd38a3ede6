"""Command line of an experiment: ``--data`` is its first option, and ``--json`` its last."""

import json
import os
import re
from argparse import ArgumentParser, Namespace
from pathlib import Path


def default_folder() -> Path | None:
    """Folder named by ``ISOMATCH_DATA``, if any."""
    named = os.environ.get("ISOMATCH_DATA")
    return Path(named) if named else None


def command_line(description: str | None, data: bool = False) -> ArgumentParser:
    """Return a parser without options, or with ``--data``.

    Parameters
    ----------
    description
        Docstring of the module, with its command: ``python -m bench.NAME``.
    data
        Whether the experiment takes a folder of meshes.
    """
    named = re.search(r"python -m bench\.\w+", description or "")
    parser = ArgumentParser(prog=named and named.group(), description=description)
    if data:
        parser.add_argument("--data", type=Path, default=default_folder(), help="folder of meshes")
    return parser


def parsed(parser: ArgumentParser) -> Namespace:
    """Add ``--json``, and parse the command line."""
    parser.add_argument("--json", action="store_true", help="end with one line of JSON")
    arguments = parser.parse_args()
    folder = getattr(arguments, "data", None)
    if folder is not None and not folder.is_dir():
        parser.error(f"--data: {folder} is not a folder")
    return arguments


def print_json(arguments: Namespace, figures: object) -> None:
    """End with a line of JSON, if the command line asks for it."""
    if arguments.json:
        print(json.dumps(figures, allow_nan=False))
