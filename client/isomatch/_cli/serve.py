"""``isomatch serve``: starts the application where it is found; it is no part of this package."""

import importlib.machinery
import os
import subprocess
import sys
from pathlib import Path
from typing import Final

HOW: Final = (
    "the service is not installed here: this package is its client. In a checkout of the project, "
    "`make serve` installs and starts it; in the folder of a checkout, or with the application "
    "installed beside it, `isomatch serve` does"
)


def application() -> bool:
    """Whether this Python finds the application, installed or in the working directory."""
    package = importlib.machinery.PathFinder.find_spec("service", [str(Path.cwd()), *sys.path])
    places = None if package is None else package.submodule_search_locations
    # Other people's packages are called "service" too.
    return any(
        Path(place, "standalone").is_dir() and Path(place, "..", "worker").is_dir()
        for place in places or ()
    )


def serve(host: str | None, port: int | None) -> int:
    """Run the application until it ends, and return its exit code.

    Raises
    ------
    FileNotFoundError
        It is not there; the message says how to get it.
    """
    if not application():
        raise FileNotFoundError(HOW)
    command = [sys.executable, "-m", "service"]
    if host is not None:
        command += ["--host", host]
    if port is not None:
        command += ["--port", str(port)]
    if os.name == "posix":
        os.execv(sys.executable, command)
    return subprocess.call(command)
