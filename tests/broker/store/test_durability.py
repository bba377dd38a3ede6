"""Promises of Redis: the disk is written, or not in time; records are evicted, or not on disk."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from redis.exceptions import RedisError

from broker.store import (
    Durability,
    EvictsRecords,
    NotOnDisk,
    check_eviction,
    connect,
    possible_losses,
)
from service.standalone import EmbeddedServer


@pytest.fixture
def own(tmp_path: Path) -> Iterator[EmbeddedServer]:
    """A server that a test may stop and configure."""
    server = EmbeddedServer(tmp_path)
    server.start()
    yield server
    server.stop()


@pytest.mark.parametrize("policy", ["always", "everysec"])
def test_what_was_waited_for_is_on_the_disk(own: EmbeddedServer, policy: str) -> None:
    with connect(own.url, retry_seconds=5) as client:
        client.config_set("appendfsync", policy)
        client.set("record", "1")
        Durability(client, 10.0).wait("record")
        persistence = client.info("persistence")
        assert persistence["aof_buffer_length"] == 0
        assert persistence["aof_pending_bio_fsync"] == 0


def test_a_disk_that_is_not_written_in_time(own: EmbeddedServer) -> None:
    with connect(own.url, retry_seconds=5) as client:
        # The file is written, and flushed to the disk whenever the system likes.
        client.config_set("appendfsync", "no")
        client.set("record", "1")
        with pytest.raises(NotOnDisk, match=r"within 0\.1 s"):
            Durability(client, 0.1).wait("record")


def test_a_record_that_a_restart_has_lost(own: EmbeddedServer) -> None:
    with connect(own.url, retry_seconds=5) as client, pytest.raises(NotOnDisk, match="restarted"):
        Durability(client, 5.0).wait("record")


def test_a_redis_without_a_file_makes_no_promise(own: EmbeddedServer) -> None:
    with connect(own.url, retry_seconds=5) as client:
        client.config_set("appendonly", "no")
        client.set("record", "1")
        Durability(client, 5.0).wait("record")


def test_a_redis_that_is_away_is_an_error(own: EmbeddedServer) -> None:
    with connect(own.url, retry_seconds=0) as client:
        client.set("record", "1")
        assert own.pid is not None
        os.kill(own.pid, signal.SIGKILL)
        while own.alive():
            time.sleep(0.01)
        with pytest.raises(RedisError):
            Durability(client, 1.0).wait("record")


def test_a_redis_that_restarts_meanwhile_is_asked_again(own: EmbeddedServer) -> None:
    with connect(own.url, retry_seconds=60, pause=0.1) as client:
        client.set("record", "1")
        Durability(client, 10.0).wait("record")
        assert own.pid is not None
        os.kill(own.pid, signal.SIGKILL)
        waiting = threading.Thread(target=Durability(client, 10.0).wait, args=("record",))
        waiting.start()
        while own.alive():
            time.sleep(0.01)
        own.start()
        waiting.join()
        assert client.exists("record")


@pytest.mark.parametrize("policy", ["allkeys-lru", "volatile-ttl"])
def test_a_redis_that_deletes_records_when_it_is_full(own: EmbeddedServer, policy: str) -> None:
    with connect(own.url, retry_seconds=5) as client:
        client.config_set("maxmemory-policy", policy)
        check_eviction(client)
        assert possible_losses(client) == [], "without a limit it is never full"
        client.config_set("maxmemory", 2**30)
        with pytest.raises(EvictsRecords, match=f"policy is {policy}; set it to noeviction"):
            check_eviction(client)
        (loss,) = possible_losses(client)
        assert policy in loss
        client.config_set("maxmemory-policy", "noeviction")
        check_eviction(client)
        assert possible_losses(client) == []


def test_a_redis_without_a_file_is_told(own: EmbeddedServer) -> None:
    with connect(own.url, retry_seconds=5) as client:
        client.config_set("appendonly", "no")
        (loss,) = possible_losses(client)
        assert "no append-only file" in loss


def test_a_redis_that_does_not_tell_its_settings_passes(own: EmbeddedServer) -> None:
    with connect(own.url, retry_seconds=5) as client:
        client.config_set("maxmemory", 2**30)
        client.config_set("maxmemory-policy", "allkeys-lru")
        client.acl_setuser("default", enabled=True, commands=["-info"])
        check_eviction(client)
        assert possible_losses(client) == []
