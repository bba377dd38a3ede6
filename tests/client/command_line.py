"""The command line: as a shell runs it, and in this process, which takes a tenth of the time."""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Final

from isomatch import cli
from typer.testing import CliRunner

COMMAND: Final = [sys.executable, "-m", "isomatch_command"]

Done = subprocess.CompletedProcess[str]


def run(*arguments: str | Path, url: str, stdin: IO[bytes] | None = None) -> Done:
    """Run a command line in this process.

    Parameters
    ----------
    arguments
        What follows the name of the program.
    url
        Where the service listens, which the environment says.
    stdin
        File that is the standard input, which is empty otherwise.

    Returns
    -------
    Its exit code, and what it wrote. Exceptions that end a program are raised.
    """
    words = list(map(str, arguments))
    told = CliRunner().invoke(
        cli.app,
        words,
        input=None if stdin is None else stdin.read(),
        env=_environment(url),
        catch_exceptions=False,
    )
    return Done(words, told.exit_code, told.stdout, told.stderr)


def run_process(*arguments: str | Path, url: str, stdin: IO[bytes] | None = None) -> Done:
    """Run a command line in a process of its own, as :func:`run` does in this one."""
    return subprocess.run(
        [*COMMAND, *map(str, arguments)],
        stdin=stdin,
        env={**os.environ, **_environment(url)},
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )


def _environment(url: str) -> Mapping[str, str]:
    return {"ISOMATCH_URL": url, "NO_COLOR": "1", "COLUMNS": "100"}
