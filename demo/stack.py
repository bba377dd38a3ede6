"""The service as a user starts it, as a context manager."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue

from broker.processes import die_with_parent

LINUX = sys.platform == "linux"
ROOT = Path(__file__).resolve().parents[1]
LISTENS = re.compile(r"isomatch listens on (http://\S+)")

START_SECONDS = 600.0
"""Compiling the numerics on a machine that never ran them takes most of it."""

STOP_SECONDS = 30.0


class StackError(Exception):
    """The service did not start; the message says what it said."""


@dataclass(frozen=True)
class Stack:
    """A running service.

    Attributes
    ----------
    url
        Where it listens.
    process
        The process that was started; the rest of the stack are its children.
    log
        File that its log goes to.
    """

    url: str
    process: subprocess.Popen[str]
    log: Path


@contextlib.contextmanager
def running_stack(settings: dict[str, str] | None = None) -> Iterator[Stack]:
    """Start the service on a free port with a data directory of its own, and stop it at the end.

    Parameters
    ----------
    settings
        ``ISOMATCH_*`` variables besides those of the environment.

    Raises
    ------
    StackError
        It does not start.
    """
    with tempfile.TemporaryDirectory(prefix="isomatch-") as directory:
        log = Path(directory, "service.log")
        # Stores named in the environment are somebody's; this stack brings its own.
        others = "ISOMATCH_REDIS_URL", "ISOMATCH_BLOB_URL"
        inherited = {k: v for k, v in os.environ.items() if k not in others}
        environment = {**inherited, "ISOMATCH_DATA_DIR": str(Path(directory, "data"))}
        with log.open("w") as log_file:
            process = subprocess.Popen(
                [sys.executable, "-m", "service", "--port", "0"],
                cwd=ROOT,
                env={**environment, **(settings or {})},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=log_file,
                text=True,
                # Ctrl-C is for this program alone, which then stops the service in order.
                start_new_session=True,
                # Nor does the service outlive a program that was killed.
                preexec_fn=partial(die_with_parent, os.getpid()) if LINUX else None,
            )
        try:
            yield Stack(_wait_until_listening(process, log), process, log)
        finally:
            stop(process)


def _wait_until_listening(process: subprocess.Popen[str], log: Path) -> str:
    said: SimpleQueue[str | None] = SimpleQueue()

    def listen() -> None:
        assert process.stdout is not None
        with process.stdout:
            for line in process.stdout:
                said.put(line)
        said.put(None)

    # The thread goes on reading, so that the service never blocks on a full pipe.
    threading.Thread(target=listen, daemon=True).start()
    try:
        while (line := said.get(timeout=START_SECONDS)) is not None:
            if found := LISTENS.search(line):
                return found.group(1)
    except Empty:
        raise StackError(f"the service did not start in {START_SECONDS:.0f} s{_end(log)}") from None
    raise StackError(f"the service ended with code {process.wait()} before it listened{_end(log)}")


def _end(log: Path) -> str:
    lines = log.read_text(errors="replace").splitlines()[-15:]
    return "".join(f"\n    {line}" for line in lines)


def stop(process: subprocess.Popen[str]) -> int:
    """Ask the service to stop, insist if it does not, and return its exit code."""
    if process.poll() is None:
        process.terminate()
    try:
        return process.wait(STOP_SECONDS)
    except (subprocess.TimeoutExpired, KeyboardInterrupt) as reason:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        code = process.wait()
        if isinstance(reason, KeyboardInterrupt):
            raise
        return code
