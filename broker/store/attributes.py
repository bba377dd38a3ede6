"""Attribute files: the record and the uploaded bytes."""

from dataclasses import dataclass

from redis import Redis
from redis.client import Pipeline
from redis.exceptions import WatchError

from broker.contracts import AttributesRecord
from broker.store.blobs import Blobs
from broker.store.connections import StoreSettings
from broker.store.keys import DEFAULT_KEYS, Keys
from broker.store.quotas import QuotaExceeded, Quotas
from broker.store.records import read_record
from broker.store.uploads import delete_candidate, watch_candidate


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
    keys
        The tenant's keys.
    """

    client: Redis
    settings: StoreSettings
    blobs: Blobs
    keys: Keys = DEFAULT_KEYS

    def get(self, attributes_id: str) -> AttributesRecord | None:
        """Return the record of a file, or None if it does not exist."""
        data = self.client.get(self.keys.attributes(attributes_id))
        return None if data is None else read_record(AttributesRecord, data)

    def use(self, attributes_id: str) -> AttributesRecord | None:
        """Return the record of a file, and extend its life."""
        with self.client.pipeline() as pipe:
            pipe.get(self.keys.attributes(attributes_id))
            self._extend(attributes_id, pipe)
            data = pipe.execute()[0]
        return None if data is None else read_record(AttributesRecord, data)

    def file(self, attributes_id: str) -> bytes | None:
        """Return the bytes of a file, and extend its life."""
        self.use(attributes_id)
        return self.blobs.get(self.keys.attributes_file(attributes_id))

    def lost(self, attributes_id: str) -> bool:
        """Whether the blob store has lost the bytes of a file."""
        return self.blobs.lost([self.keys.attributes_file(attributes_id)])

    def expired(self, attributes_id: str) -> bool:
        """Whether a file that does not exist has expired (and was not deleted)."""
        return bool(self.client.exists(self.keys.attributes_tombstone(attributes_id)))

    def accept(self, record: AttributesRecord, data: bytes, job_id: str) -> None:
        """Store a file made of a job's candidate, all at once.

        Raises
        ------
        CandidateGone
            It has expired, was rejected, or has been stored.
        QuotaExceeded
            The tenant has as many bytes as it may have.
        """
        key = self.keys.attributes_file(record.id)
        candidate = self.keys.candidate(record.id, record.file_type, job_id)
        stored, quotas = self.blobs.put(key, data), Quotas(self.client, self.settings, self.keys)
        with self.client.pipeline() as pipe:
            while True:
                try:
                    # As for a shape, blobs of a candidate that is gone are left to the sweep.
                    watch_candidate(candidate, pipe)
                    # Its bytes have been counted, as the candidate's.
                    quotas.check(0, pipe=pipe)
                    pipe.multi()
                    self.blobs.look_up(candidate, pipe)
                    self.blobs.link(key, stored, pipe)
                    pipe.set(self.keys.attributes(record.id), record.model_dump_json())
                    pipe.set(self.keys.attributes_tombstone(record.id), b"")
                    self._extend(record.id, pipe)
                    delete_candidate(self.keys, record.id, record.file_type, job_id, pipe)
                    validated, *_ = pipe.execute()
                except WatchError:
                    # The candidate is gone, or the tenant got something else meanwhile.
                    continue
                except QuotaExceeded:
                    self.blobs.discard([(key, stored)])
                    raise
                self.blobs.discard([(candidate, validated)])
                return

    def delete(self, attributes_id: str) -> bool:
        """Delete a file; False if it did not exist."""
        key = self.keys.attributes_file(attributes_id)
        with self.client.pipeline() as pipe:
            pipe.delete(self.keys.attributes(attributes_id))
            self.blobs.look_up(key, pipe)
            pipe.delete(self.keys.attributes_tombstone(attributes_id))
            self.blobs.unlink([key], pipe)
            existed, stored, *_ = pipe.execute(raise_on_error=False)
        self.blobs.discard([(key, stored)])
        return bool(existed)

    def _extend(self, attributes_id: str, pipe: Pipeline) -> None:
        ttl = self.settings.shape_ttl
        pipe.expire(self.keys.attributes(attributes_id), ttl)
        pipe.expire(self.keys.attributes_file(attributes_id), ttl)
        pipe.expire(self.keys.attributes_tombstone(attributes_id), ttl + self.settings.trace_ttl)
