"""Commands that are sent again because the connection broke before their reply."""

import select
import socket
from collections.abc import Callable, Iterator
from contextlib import suppress
from threading import Event, Thread

import pytest

from broker.contracts import (
    DissimilaritiesPayload,
    DissimilarityParameters,
    JobState,
    MatchParameters,
    MatchPayload,
    PicturePayload,
    ValidationPayload,
)
from broker.queue import JobQueue, QueueSettings
from broker.store import DEFAULT_KEYS, CandidateGone, Store
from service.standalone import EmbeddedServer
from tests.broker.store.records import running
from tests.worker.records import shape_record
from worker.settings import WorkerSettings

SHAPE = "a" * 32

UPLOAD = ValidationPayload(shape=SHAPE, name="x", file_type="off")
MATCH = MatchPayload(source="a", target="b", parameters=MatchParameters())
PICTURE = PicturePayload(job="x")
COMPARISON = DissimilaritiesPayload(
    shapes=("a", "b"), labels=("a", "b"), parameters=DissimilarityParameters()
)


def pass_on(client: socket.socket, server: socket.socket, until: list[bytes]) -> bool:
    """Forward both directions until one side closes, or until the reply to the first command.

    Returns whether that reply, which is lost, has come; the list is empty then.
    """
    asked = False
    while True:
        ready, _, _ = select.select([client, server], [], [])
        if client in ready:
            said = client.recv(65536)
            if not said:
                return False
            if any(command in said for command in until):
                until.clear()
                asked = True
            server.sendall(said)
        if server in ready:
            answer = server.recv(65536)
            if asked or not answer:
                return asked
            client.sendall(answer)


@pytest.fixture
def meanwhile() -> list[Callable[[], object]]:
    """What others do before the connection breaks."""
    return []


@pytest.fixture
def forgetful(
    server: EmbeddedServer,
    store: Store,
    settings: WorkerSettings,
    request: pytest.FixtureRequest,
    meanwhile: list[Callable[[], object]],
) -> Iterator[Store]:
    """The empty store, over a connection that breaks before the first transaction's reply.

    Or before that to another command, the fixture's parameter.
    """
    until, threads, over = [getattr(request, "param", b"EXEC")], list[Thread](), Event()

    def forward(client: socket.socket) -> None:
        with client, socket.socket(socket.AF_UNIX) as behind:
            behind.connect(server.url.removeprefix("unix://"))
            if pass_on(client, behind, until):
                for act in meanwhile:
                    act()

    def serve() -> None:
        while not over.is_set():
            with suppress(TimeoutError):
                client, _ = listening.accept()
                threads.append(Thread(target=forward, args=(client,)))
                threads[-1].start()

    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.settimeout(0.05)
        threads.append(Thread(target=serve))
        threads[0].start()
        url = f"redis://127.0.0.1:{listening.getsockname()[1]}?db=1"
        opened = Store.open(
            settings.model_copy(update={"redis_url": url}), retry_seconds=30, pause=0.05
        )
        yield opened
        opened.close()
        over.set()
        for thread in threads:
            thread.join()
    assert until == []


@pytest.mark.parametrize("has_ended", [False, True])
@pytest.mark.parametrize("payload", [MATCH, PICTURE])
def test_a_job_is_queued_once(
    store: Store,
    forgetful: Store,
    meanwhile: list[Callable[[], object]],
    payload: MatchPayload | PicturePayload,
    has_ended: bool,
) -> None:
    def work() -> None:
        (job,) = store.jobs.active()
        assert store.jobs.claim(job.id, "me")
        if has_ended:
            assert store.jobs.succeed(job.id, "me", b"{}")

    meanwhile.append(work)
    queue = JobQueue(forgetful, QueueSettings())
    if isinstance(payload, MatchPayload):
        job = queue.submit(payload).id
    else:
        job = queue.submit_picture(payload)
    assert store.jobs.state(job) is (JobState.SUCCEEDED if has_ended else JobState.RUNNING)
    assert store.client.lrange(queue.rq.current.key, 0, -1) == [job.encode()]


def test_an_upload_is_validated_once(
    store: Store, forgetful: Store, meanwhile: list[Callable[[], object]]
) -> None:
    def accept() -> None:
        (job,) = store.jobs.active()
        assert store.jobs.claim(job.id, "me")
        store.shapes.accept(shape_record(SHAPE), b"data", b"mesh", b"geometry", job.id)
        assert store.jobs.succeed(job.id, "me")

    meanwhile.append(accept)
    job = JobQueue(forgetful, QueueSettings()).submit_validation(UPLOAD, b"data")
    assert store.jobs.state(job) is JobState.SUCCEEDED


def test_a_time_slice_is_queued_once(
    store: Store, forgetful: Store, meanwhile: list[Callable[[], object]]
) -> None:
    comparison = JobQueue(store, QueueSettings()).submit(COMPARISON)
    assert store.jobs.claim(comparison.id, comparison.id)
    second = f"{comparison.id}-2"
    meanwhile.append(lambda: store.jobs.claim(second, "me"))
    JobQueue(forgetful, QueueSettings()).submit_time_slice(comparison)
    assert store.jobs.state(second) is JobState.RUNNING


def test_a_shape_is_stored_once(store: Store, forgetful: Store) -> None:
    job = JobQueue(store, QueueSettings()).submit_validation(UPLOAD, b"data")
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
