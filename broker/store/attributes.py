"""Attribute files: the record and the uploaded bytes."""

from dataclasses import dataclass

from redis import Redis
from redis.client import Pipeline

from broker.contracts import AttributesRecord
from broker.store import keys
from broker.store.blobs import Blobs
from broker.store.connections import StoreSettings
from broker.store.records import read_record
from broker.store.uploads import delete_candidate


@dataclass(frozen=True)
class Attributes:
    """The stored attribute files; they live as long as shapes.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        Times to live.
    blobs
        The bytes.
    """

    client: Redis
    settings: StoreSettings
    blobs: Blobs

    def get(self, attributes_id: str) -> AttributesRecord | None:
        """Return the record of a file, or None if it does not exist."""
        data = self.client.get(keys.attributes(attributes_id))
        return None if data is None else read_record(AttributesRecord, data)

    def use(self, attributes_id: str) -> AttributesRecord | None:
        """Return the record of a file, and extend its life."""
        with self.client.pipeline() as pipe:
            pipe.get(keys.attributes(attributes_id))
            self._extend(attributes_id, pipe)
            data = pipe.execute()[0]
        return None if data is None else read_record(AttributesRecord, data)

    def file(self, attributes_id: str) -> bytes | None:
        """Return the bytes of a file, and extend its life."""
        self.use(attributes_id)
        return self.blobs.get(keys.attributes_file(attributes_id))

    def expired(self, attributes_id: str) -> bool:
        """Whether a file that does not exist has expired (and was not deleted)."""
        return bool(self.client.exists(keys.attributes_tombstone(attributes_id)))

    def add(self, record: AttributesRecord, data: bytes, job_id: str) -> None:
        """Store a file made of a job's candidate, all at once."""
        key = keys.attributes_file(record.id)
        candidate = keys.candidate(record.id, record.file_type, job_id)
        stored = self.blobs.put(key, data)
        with self.client.pipeline() as pipe:
            self.blobs.look_up(candidate, pipe)
            self.blobs.link(key, stored, pipe)
            pipe.set(keys.attributes(record.id), record.model_dump_json())
            pipe.set(keys.attributes_tombstone(record.id), b"")
            self._extend(record.id, pipe)
            delete_candidate(record.id, record.file_type, job_id, pipe)
            validated, *_ = pipe.execute()
        self.blobs.discard([(candidate, validated)])

    def delete(self, attributes_id: str) -> bool:
        """Delete a file; False if it did not exist."""
        key = keys.attributes_file(attributes_id)
        with self.client.pipeline() as pipe:
            pipe.delete(keys.attributes(attributes_id))
            self.blobs.look_up(key, pipe)
            pipe.delete(key, keys.attributes_tombstone(attributes_id))
            existed, stored, _ = pipe.execute(raise_on_error=False)
        self.blobs.discard([(key, stored)])
        return bool(existed)

    def _extend(self, attributes_id: str, pipe: Pipeline) -> None:
        ttl = self.settings.shape_ttl
        pipe.expire(keys.attributes(attributes_id), ttl)
        pipe.expire(keys.attributes_file(attributes_id), ttl)
        pipe.expire(keys.attributes_tombstone(attributes_id), ttl + self.settings.trace_ttl)
