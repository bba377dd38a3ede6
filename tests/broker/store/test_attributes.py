"""Attribute files in the store: kept as long as shapes, and what is left of expired ones."""

import pytest

from broker.contracts import (
    AttributesRecord,
    AttributeSummary,
    AttributesValidationPayload,
    attribute_format_of,
    attributes_id,
)
from broker.queue import JobQueue, QueueSettings
from broker.store import DEFAULT_KEYS, Store
from tests.worker.records import CREATED

DATA = b"part\n1\n2\n"
NAME = attributes_id(DATA)
RECORD = AttributesRecord(
    id=NAME,
    name="parts.csv",
    file_type="csv",
    bytes=len(DATA),
    rows=2,
    attributes=(AttributeSummary(name="part", type="integer", columns=()),),
    created=CREATED,
)


def put(store: Store) -> None:
    payload = AttributesValidationPayload(attributes=NAME, name="parts.csv", file_type="csv")
    job = JobQueue(store, QueueSettings()).submit_validation(payload, DATA)
    store.attributes.accept(RECORD, DATA, job)


@pytest.fixture
def stored(store: Store) -> Store:
    put(store)
    return store


def test_a_file_is_kept_with_its_record(stored: Store) -> None:
    assert stored.attributes.get(NAME) == stored.attributes.use(NAME) == RECORD
    assert stored.attributes.file(NAME) == DATA
    assert not [key for key in stored.client.keys("*") if b"candidate" in key]
    ttl = stored.attributes.settings.shape_ttl
    for key in (DEFAULT_KEYS.attributes(NAME), DEFAULT_KEYS.attributes_file(NAME)):
        assert (
            0
            < stored.client.ttl(key)
            <= ttl
            < stored.client.ttl(DEFAULT_KEYS.attributes_tombstone(NAME))
        )


def test_use_extends_the_life(stored: Store) -> None:
    stored.client.expire(DEFAULT_KEYS.attributes(NAME), 10)
    stored.client.expire(DEFAULT_KEYS.attributes_file(NAME), 10)
    stored.attributes.use(NAME)
    assert stored.client.ttl(DEFAULT_KEYS.attributes(NAME)) > 10
    assert stored.client.ttl(DEFAULT_KEYS.attributes_file(NAME)) > 10


def test_an_expired_file_is_told_from_a_deleted_one(stored: Store) -> None:
    stored.client.delete(DEFAULT_KEYS.attributes(NAME), DEFAULT_KEYS.attributes_file(NAME))
    assert stored.attributes.file(NAME) is None
    assert stored.attributes.expired(NAME)
    put(stored)
    assert stored.attributes.delete(NAME)
    assert not stored.attributes.expired(NAME)
    assert not stored.attributes.delete(NAME)


@pytest.mark.parametrize(
    ("name", "known"),
    [("a.CSV", "csv"), ("b.npz", "npz"), ("c.txt", "txt"), ("d.doc", None), ("npz", None)],
)
def test_formats_by_name(name: str, known: str | None) -> None:
    assert attribute_format_of(name) == known
