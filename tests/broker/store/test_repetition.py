"""Commands that are sent again because the connection broke before their reply."""

import select
import socket
from collections.abc import Iterator
from threading import Thread

import pytest

from broker.contracts import JobState, ValidationPayload
from broker.queue import JobQueue, QueueSettings
from broker.store import DEFAULT_KEYS, CandidateGone, Store
from service.standalone import EmbeddedServer
from tests.broker.store.test_store import running
from tests.worker.records import shape_record
from worker.settings import WorkerSettings

SHAPE = "a" * 32


def pass_on(client: socket.socket, server: socket.socket, until: bytes | None) -> None:
    """Forward both directions until the reply to a command, or until one side closes."""
    asked = False
    while True:
        ready, _, _ = select.select([client, server], [], [])
        if client in ready:
            said = client.recv(65536)
            if not said:
                return
            asked = asked or (until is not None and until in said)
            server.sendall(said)
        if server in ready:
            answer = server.recv(65536)
            if asked or not answer:
                return
            client.sendall(answer)


@pytest.fixture
def forgetful(
    server: EmbeddedServer, store: Store, settings: WorkerSettings, request: pytest.FixtureRequest
) -> Iterator[Store]:
    """The empty store, over a connection that breaks before the first transaction's reply.

    Or before that to another command, the fixture's parameter.
    """
    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.settimeout(60.0)

        def serve() -> None:
            for until in (getattr(request, "param", b"EXEC"), None):
                client, _ = listening.accept()
                with client, socket.socket(socket.AF_UNIX) as behind:
                    behind.connect(server.url.removeprefix("unix://"))
                    pass_on(client, behind, until)

        thread = Thread(target=serve)
        thread.start()
        url = f"redis://127.0.0.1:{listening.getsockname()[1]}?db=1"
        opened = Store.open(
            settings.model_copy(update={"redis_url": url}), retry_seconds=30, pause=0.05
        )
        yield opened
        opened.close()
        thread.join()


def test_a_shape_is_stored_once(store: Store, forgetful: Store) -> None:
    payload = ValidationPayload(shape=SHAPE, name="x", file_type="off")
    job = JobQueue(store, QueueSettings()).submit_validation(payload, b"data")
    with pytest.raises(CandidateGone):
        forgetful.shapes.accept(shape_record(SHAPE), b"data", b"mesh", b"geometry", job)
    assert store.shapes.get(SHAPE) == shape_record(SHAPE)
    assert (store.shapes.upload(SHAPE), store.shapes.mesh(SHAPE)) == (b"data", b"mesh")
    assert not store.client.exists(DEFAULT_KEYS.candidate(SHAPE, "off", job))


@pytest.mark.parametrize("forgetful", [b"EVALSHA"], indirect=True)
def test_a_job_ends_with_the_result_of_a_call_that_is_repeated(
    store: Store, forgetful: Store
) -> None:
    job, other = running(store.jobs), running(store.jobs)
    # Now Redis knows the script.
    assert store.jobs.succeed(other, "r", b"{}")
    assert forgetful.jobs.succeed(job, "r", b"{}")
    assert store.jobs.state(job) is JobState.SUCCEEDED
    assert store.results.document(job) is not None
