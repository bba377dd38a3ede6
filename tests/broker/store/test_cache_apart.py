"""The spectrum cache in a Redis of its own, which evicts, is full, or does not answer."""

import socket
import time
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import pytest
from redis import Redis
from redis.exceptions import TimeoutError as RedisTimeoutError

from broker import circuit_breaker
from broker.circuit_breaker import CircuitBreaker
from broker.contracts import (
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    SpectrumKey,
    shape_id,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Keys, Store, connect
from broker.store.connections import CACHE_TIMEOUT
from service.standalone import EmbeddedServer
from tests.waiting import until
from tests.worker.figures import blob_file
from tests.workers import ended, validation, worker
from worker.settings import WorkerSettings

MIB = 1024**2


@pytest.fixture(scope="module")
def second(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmbeddedServer]:
    """A second server, with eviction."""
    embedded = EmbeddedServer(tmp_path_factory.mktemp("cache"))
    embedded.start()
    yield embedded
    embedded.stop()


@pytest.fixture
def cache(second: EmbeddedServer) -> Iterator[Redis]:
    """A connection to the second server, running, empty and with eviction."""
    if not second.alive():
        second.start()
    with Redis.from_url(second.url) as client:
        client.flushall()
        client.config_set("maxmemory-policy", "allkeys-lfu")
        client.config_set("maxmemory", "0")
        yield client


@pytest.fixture
def apart(
    store: Store, cache: Redis, second: EmbeddedServer, settings: WorkerSettings
) -> Iterator[Store]:
    """An empty store whose cache is on the second server."""
    opened = Store.open(settings.model_copy(update={"cache_url": second.url}), retry_seconds=0)
    yield opened
    opened.close()


def limit(cache: Redis, more: int) -> None:
    """Limit the server to so many bytes more than it uses now."""
    cache.config_set("maxmemory", int(cache.info("memory")["used_memory"]) + more)


def test_the_cache_holds_only_blobs_and_their_list(apart: Store, cache: Redis) -> None:
    key = SpectrumKey("a", 10)
    apart.spectra.put(key, b"spectrum")
    assert apart.spectra.lock(key, "me", 5.0)
    apart.spectra.count_computed()
    assert sorted(cache.scan_iter()) == sorted(
        name.encode()
        for name in (Keys.CACHED_SPECTRA, Keys.CACHED_SIZES, Keys.cached_spectrum(key))
    )
    assert sorted(apart.client.scan_iter()) == sorted(
        name.encode()
        for name in (DEFAULT_KEYS.cached_of("a"), Keys.spectrum_lock(key), Keys.SPECTRUM_COUNTERS)
    )


def test_evicted_spectra_are_missing_and_nothing_else_is(apart: Store, cache: Redis) -> None:
    apart.client.set("isomatch:kept", b"x")
    limit(cache, 8 * MIB)
    names = [SpectrumKey(f"{number:032x}", 10) for number in range(32)]
    for name in names:
        apart.spectra.put(name, bytes(MIB))
    assert int(cache.info("stats")["evicted_keys"]) > 0
    there = [apart.spectra.has(name) for name in names]
    assert 0 < sum(there) < len(names)
    for name, is_there in zip(names, there, strict=True):
        assert (apart.spectra.get(name) is not None) is is_there
    assert apart.client.get("isomatch:kept") == b"x"


@pytest.fixture
def together(
    cache: Redis, second: EmbeddedServer, settings: WorkerSettings
) -> Iterator[tuple[Store, Redis]]:
    """A store on the second server, with the cache, that evicts nothing."""
    cache.config_set("maxmemory-policy", "noeviction")
    opened = Store.open(settings.model_copy(update={"redis_url": second.url}), retry_seconds=0)
    yield opened, cache
    opened.close()


def test_a_cache_beside_the_queue_leaves_it_memory(together: tuple[Store, Redis]) -> None:
    store, cache = together
    assert store.spectra.budget() == store.settings.cache_bytes
    limit(cache, 16 * MIB)
    names = [SpectrumKey(f"{number:032x}", 10) for number in range(32)]
    assert all(store.spectra.put(name, bytes(MIB)) for name in names)
    assert 4 * MIB < store.spectra.cached_bytes() < 8.5 * MIB
    # What the queue takes, the cache gives back.
    for number in range(6):
        store.client.set(f"isomatch:job:{number}", bytes(MIB))
    assert store.spectra.put(names[0], bytes(MIB))
    assert store.spectra.cached_bytes() < 5.5 * MIB
    assert store.spectra.get(names[0]) is not None
    assert not store.spectra.put(names[1], bytes(8 * MIB))


def test_a_full_redis_fails_no_job_for_its_cache(together: tuple[Store, Redis]) -> None:
    store, cache = together
    old, new = SpectrumKey("a", 10), SpectrumKey("b", 10)
    assert store.spectra.put(old, bytes(MIB))
    limit(cache, -1)
    assert store.spectra.get(old) == bytes(MIB)
    # What is cached makes room.
    assert not store.spectra.put(new, bytes(2 * MIB))
    limit(cache, -3 * MIB)
    assert not store.spectra.put(new, b"spectrum")
    assert not store.spectra.has(old)
    assert store.spectra.cached_bytes() == 0


def test_a_shape_is_dropped_although_the_list_was_evicted(apart: Store, cache: Redis) -> None:
    mine, others = SpectrumKey("a" * 32, 10), SpectrumKey("b" * 32, 10)
    for key in (mine, others):
        apart.spectra.put(key, b"spectrum")
    cache.delete(Keys.CACHED_SPECTRA, Keys.CACHED_SIZES)
    apart.spectra.drop("a" * 32)
    assert not apart.spectra.has(mine)
    assert apart.spectra.has(others)
    assert apart.spectra.put(mine, b"spectrum")


def test_a_read_only_cache_is_tolerated(apart: Store, cache: Redis) -> None:
    known, other = SpectrumKey("a", 10), SpectrumKey("b", 10)
    assert apart.spectra.put(known, b"spectrum")
    # As after a failover: a replica can be read but not written.
    cache.replicaof("127.0.0.1", "1")
    try:
        assert not apart.spectra.put(other, b"spectrum")
        assert apart.spectra.get(known) == b"spectrum"
        apart.spectra.drop("a")
    finally:
        cache.replicaof("NO", "ONE")


def connections(listener: socket.socket) -> int:
    """Number of connections since the last call."""
    listener.setblocking(False)
    made = 0
    while True:
        try:
            listener.accept()[0].close()
        except BlockingIOError:
            return made
        made += 1


def test_the_circuit_opens_after_one_timeout(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    key, clock = SpectrumKey("a", 10), SimpleNamespace(now=0.0)
    clock.monotonic = lambda: clock.now
    monkeypatch.setattr(circuit_breaker, "time", clock)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"redis://127.0.0.1:{silent.getsockname()[1]}"
        with connect(url, retry_seconds=0, timeout=0.5) as cache:
            spectra = replace(store.spectra, cache=cache, circuit=CircuitBreaker())

            def look() -> None:
                assert not spectra.has(key)
                assert spectra.get(key) is None
                assert spectra.get_many([]) == []
                assert not spectra.put(key, b"spectrum")
                spectra.drop("a")
                assert spectra.cached_bytes() == 0

            look()
            look()
            assert connections(silent) == 1
            # It is left alone six times as long as it was waited for.
            clock.now = 2.9
            look()
            assert connections(silent) == 0
            clock.now = 10_000.0
            look()
            look()
            assert connections(silent) == 1


def test_a_cache_that_refuses_connections_costs_nothing(
    apart: Store, second: EmbeddedServer
) -> None:
    key = SpectrumKey("a", 10)
    assert apart.spectra.put(key, b"spectrum")
    second.stop()
    start = time.monotonic()
    for _ in range(10):
        assert apart.spectra.get(key) is None
    assert time.monotonic() - start < 5.0
    # And it is used as soon as it is there again, over a connection of before.
    second.start()
    until(lambda: apart.spectra.put(key, b"spectrum"), 60.0)
    assert apart.spectra.get(key) == b"spectrum"


def test_a_cache_that_answers_again_is_used(apart: Store) -> None:
    spectra, key = replace(apart.spectra, circuit=CircuitBreaker()), SpectrumKey("a", 10)
    spectra.circuit.open(1000.0)
    assert not spectra.put(key, b"spectrum")
    spectra.circuit.open(0.0)
    assert spectra.put(key, b"spectrum")
    assert spectra.has(key)


def test_workers_have_a_timeout_for_the_cache(server: EmbeddedServer) -> None:
    settings = WorkerSettings(
        redis_url=server.url, cache_url="redis://127.0.0.1:1", blob_url="file:///nowhere"
    )
    opened = Store.open(settings, retry_seconds=30.0)
    options = opened.cache.connection_pool.connection_kwargs
    assert options["socket_timeout"] == CACHE_TIMEOUT
    assert RedisTimeoutError not in options["retry_on_error"]
    assert RedisTimeoutError in opened.client.connection_pool.connection_kwargs["retry_on_error"]
    opened.close()


def test_matches_work_without_the_cache(
    apart: Store, second: EmbeddedServer, settings: WorkerSettings
) -> None:
    queue = JobQueue(apart, settings)
    data = blob_file(3)
    parameters = MatchParameters(points=8, eigenpairs=30, orientation=False)
    payload = MatchPayload(source=shape_id(data), target=shape_id(data), parameters=parameters)

    def matched() -> JobRecord:
        record = ended(queue, queue.submit(payload).id)
        assert record.state is JobState.SUCCEEDED, record
        return record

    def computed() -> int:
        return apart.spectra.counts().computed

    with worker(queue, ISOMATCH_CACHE_URL=second.url):
        ended(queue, validation(queue, data))
        first = matched()
        before = computed()
        matched()
        assert computed() == before, "the second match takes the spectrum from the cache"
        second.stop()
        again = matched()
        assert computed() > before, "without the cache it is computed again"
        second.start()
        with Redis.from_url(second.url) as cache:
            cache.flushall()
        matched()
        settled = computed()
        matched()
        assert computed() == settled, "and kept once the cache is there again"
    for record in (first, again):
        assert apart.results.document(record.id) is not None
