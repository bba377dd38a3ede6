"""A real server of S3's protocol, on this machine, that can be killed and started again."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Final

import pytest

from broker.blobs.object_storage import ObjectStorage
from broker.processes import die_with_parent

BUCKET: Final = "isomatch"
ACCESS: Final = {
    "AWS_ACCESS_KEY_ID": "tests",
    "AWS_SECRET_ACCESS_KEY": "a secret of tests",
    "AWS_REGION": "us-east-1",
}
READER: Final = {
    "AWS_ACCESS_KEY_ID": "readers",
    "AWS_SECRET_ACCESS_KEY": "a secret of readers",
}
"""Access that may not write."""

_PORTS: Final = (
    "master.port",
    "master.port.grpc",
    "volume.port",
    "volume.port.grpc",
    "filer.port",
    "filer.port.grpc",
    "s3.port",
    "s3.port.grpc",
)


def _identity(access: dict[str, str], *actions: str) -> dict[str, object]:
    key, secret = access["AWS_ACCESS_KEY_ID"], access["AWS_SECRET_ACCESS_KEY"]
    credentials = [{"accessKey": key, "secretKey": secret}]
    return {"name": key, "credentials": credentials, "actions": actions}


class ObjectServer:
    """SeaweedFS with one bucket.

    Parameters
    ----------
    binary
        The program.
    folder
        Its data, and its log.
    """

    def __init__(self, binary: str, folder: Path) -> None:
        self._folder = folder
        ports = dict(zip(_PORTS, free_ports(len(_PORTS)), strict=True))
        self.port = ports["s3.port"]
        self._ports = ports.values()
        identities = [
            _identity(ACCESS, "Admin", "Read", "Write", "List"),
            _identity(READER, "Read", "List"),
        ]
        settings = folder / "s3.json"
        settings.write_text(json.dumps({"identities": identities}))
        data = folder / "data"
        data.mkdir()
        options: dict[str, object] = {
            "dir": data,
            "ip": "127.0.0.1",
            "ip.bind": "127.0.0.1",
            # Otherwise it reports statistics to its makers.
            "master.telemetry": "false",
            # A master that was killed waits so long before it elects itself: 10 s otherwise.
            "master.electionTimeout": "1s",
            "master.volumeSizeLimitMB": 64,
            "volume.max": 20,
            "volume.preStopSeconds": 0,
            "filer": "true",
            "filer.localSocket": folder / "filer.sock",
            "s3": "true",
            "s3.localSocket": folder / "s3.sock",
            "s3.config": settings,
            "s3.port.iceberg": 0,
            "s3.port.lance": 0,
            **ports,
        }
        self._command = [binary, "server", *(f"-{name}={to}" for name, to in options.items())]
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def endpoint(self) -> str:
        """Address of the server."""
        return f"http://127.0.0.1:{self.port}"

    @property
    def environment(self) -> dict[str, str]:
        """Variables of processes that use it."""
        return {**ACCESS, "AWS_ENDPOINT_URL": self.endpoint}

    def start(self) -> None:
        """Start it, and wait until it takes objects."""
        with (self._folder / "log").open("ab") as log:
            self._process = subprocess.Popen(
                self._command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                preexec_fn=(
                    partial(die_with_parent, os.getpid()) if sys.platform == "linux" else None
                ),
            )
        deadline = time.monotonic() + 120
        while not self._answers():
            assert self._process.poll() is None, (self._folder / "log").read_text()[-2000:]
            assert time.monotonic() < deadline
            time.sleep(0.1)

    def kill(self) -> None:
        """Kill it."""
        assert self._process is not None
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        # It puts sockets there, wherever its data are.
        for port in self._ports:
            for left in Path("/tmp").glob(f"seaweedfs-*-{port}.sock"):
                left.unlink(missing_ok=True)

    def _answers(self) -> bool:
        try:
            urllib.request.urlopen(self.endpoint, timeout=5)
        except urllib.error.HTTPError as error:
            return error.code == 403  # without credentials
        except OSError:
            return False
        return True


def free_ports(count: int) -> list[int]:
    """Return ports of this machine that nobody listens on."""
    with ExitStack() as held:
        found = []
        for _ in range(count):
            listening = held.enter_context(socket.socket())
            listening.bind(("127.0.0.1", 0))
            found.append(int(listening.getsockname()[1]))
        return found


@contextmanager
def environment(variables: dict[str, str]) -> Iterator[None]:
    """Set variables of the environment for as long as a block of code lasts."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in variables.items():
            patch.setenv(name, value)
        yield


def object_storage(server: ObjectServer, patience: float, prefix: str = "") -> ObjectStorage:
    """Return the blob store in a server's bucket."""
    with environment(server.environment):
        return ObjectStorage(f"s3://{BUCKET}/{prefix}", patience)


@pytest.fixture(scope="session")
def object_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ObjectServer]:
    """A running server; tests that kill it start it again."""
    binary = Path(sys.prefix, "bin", "weed")
    found = str(binary) if binary.exists() else shutil.which("weed")
    if found is None:
        pytest.skip("no server of object storage is installed")
    server = ObjectServer(found, tmp_path_factory.mktemp("objects"))
    server.start()
    # The server makes a bucket when the first object is put into it.
    object_storage(server, 60.0).put("first/object", b"")
    yield server
    server.kill()
