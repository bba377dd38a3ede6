"""``isomatch serve``: starts the service, which is not part of this package, if it is installed."""

import importlib.machinery
import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated, Final

import typer

from isomatch._cli.exit_codes import leave

NOT_INSTALLED: Final = (
    "the service is not installed: this package is its client. In a checkout of the project, "
    "`make serve` installs and starts the service; `isomatch serve` starts it in the folder of a "
    "checkout, or where the application is installed"
)


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on [127.0.0.1].")] = None,
    port: Annotated[
        int | None, typer.Option(help="Port to listen on, 0 for a free one [8000].")
    ] = None,
) -> None:
    """Run the whole service on this machine until interrupted, where it is installed.

    Settings are environment variables, ISOMATCH_WORKERS, ISOMATCH_DATA_DIR, and so on.
    """
    try:
        code = start(host, port)
    except FileNotFoundError as error:
        leave(error)
    raise typer.Exit(code)


def application() -> bool:
    """True if the service is installed, or in the working directory."""
    package = importlib.machinery.PathFinder.find_spec("service", [str(Path.cwd()), *sys.path])
    places = None if package is None else package.submodule_search_locations
    # Other packages may be called "service", too.
    return any(
        Path(place, "standalone").is_dir() and Path(place, "..", "worker").is_dir()
        for place in places or ()
    )


def start(host: str | None, port: int | None) -> int:
    """Run the service until it ends, and return its exit code.

    Raises
    ------
    FileNotFoundError
        The service is not installed; the message says how to install it.
    """
    if not application():
        raise FileNotFoundError(NOT_INSTALLED)
    command = [sys.executable, "-m", "service"]
    if host is not None:
        command += ["--host", host]
    if port is not None:
        command += ["--port", str(port)]
    if os.name == "posix":
        os.execv(sys.executable, command)
    return subprocess.call(command)
