"""A worker that joins over the network: by TCP, with a password, through TLS; a real server.

The server that comes as a Python package speaks no TLS: a relay speaks it before it, as operators
do with servers of that kind.
"""

import asyncio
import ssl
import subprocess
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import pytest
import trustme
from redis.exceptions import RedisError

from broker.contracts import JobState
from broker.queue import JobQueue
from broker.store import Store, connect
from service.standalone import listening, server_binary
from tests.blobs import blob_url
from tests.worker.figures import blob_file
from tests.workers import ended, validation, worker
from worker.settings import WorkerSettings

PASSWORD = "it's a secret/of:ours"


@dataclass(frozen=True)
class Secured:
    """A store that requires TLS and a password."""

    port: int
    authority: Path

    def url(self, password: str = PASSWORD, trusting: bool = True) -> str:
        """Its URL."""
        trust = f"?ssl_ca_certs={quote(str(self.authority))}" if trusting else ""
        return f"rediss://:{quote(password, safe='')}@127.0.0.1:{self.port}/0{trust}"


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """Port of a server that requires the password."""
    folder = tmp_path_factory.mktemp("plain")
    with listening("127.0.0.1", 0) as free:
        port = int(free.getsockname()[1])
    options = ["--port", str(port), "--bind", "127.0.0.1", "--save", "", "--requirepass", PASSWORD]
    with (folder / "log").open("wb") as log:
        process = subprocess.Popen([server_binary(), *options], cwd=folder, stdout=log)
    yield port
    process.terminate()
    process.wait()


@pytest.fixture(scope="module")
def secured(plain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Secured]:
    file = tmp_path_factory.mktemp("tls") / "authority.pem"
    authority = trustme.CA()
    authority.cert_pem.write_to_path(file)
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    authority.issue_cert("127.0.0.1").configure_cert(context)
    loop = asyncio.new_event_loop()
    server = loop.run_until_complete(_relay(plain, context))
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    found = Secured(server.sockets[0].getsockname()[1], file)
    with connect(found.url(), retry_seconds=120, pause=0.05) as client:
        client.ping()
    yield found
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    server.close()
    for task in asyncio.all_tasks(loop):
        task.cancel()
    loop.run_until_complete(asyncio.sleep(0.05))
    loop.close()


async def _relay(port: int, context: ssl.SSLContext) -> asyncio.Server:
    async def copy(source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
        try:
            while data := await source.read(65536):
                target.write(data)
                await target.drain()
        except OSError:
            pass
        finally:
            target.close()

    async def join(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        inner_reader, inner_writer = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.gather(copy(reader, inner_writer), copy(inner_reader, writer))

    return await asyncio.start_server(join, "127.0.0.1", 0, ssl=context)


def test_a_worker_joins(secured: Secured, tmp_path: Path) -> None:
    settings = WorkerSettings(redis_url=secured.url(), blob_url=blob_url(tmp_path))
    store = Store.open(settings, retry_seconds=1)
    queue = JobQueue(store, settings)
    with worker(queue):
        assert ended(queue, validation(queue, blob_file(1))).state is JobState.SUCCEEDED
    store.close()


def test_others_are_refused(secured: Secured) -> None:
    for url in (secured.url(password="guessed"), secured.url(trusting=False)):
        with pytest.raises(RedisError), connect(url, retry_seconds=0) as client:
            client.ping()
