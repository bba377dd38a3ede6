"""Records with bytes in the blob store: what shapes, prototypes and attribute files share."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar, cast

from redis.client import Pipeline

from broker.contracts import AttributesRecord, PrototypeRecord, ShapeRecord
from broker.store.blobs import BlobReference
from broker.store.listings import Listing, Page
from broker.store.quotas import QuotaExceeded, Quotas
from broker.store.records import read_record, readable_records
from broker.store.tenant_data import TenantData
from broker.store.uploads import delete_candidate

RecordT = TypeVar("RecordT", ShapeRecord, PrototypeRecord, AttributesRecord)


@dataclass(frozen=True)
class Layout(Generic[RecordT]):
    """Where the records of one kind are.

    Parameters
    ----------
    model
        Type of the records.
    record, tombstone
        Return the keys of a record, and of the trace that it leaves when it expires.
    contents
        Return the keys of the references to its bytes.
    listing
        Key of the listing of all records; None if there is none.
    """

    model: type[RecordT]
    record: Callable[[str], str]
    tombstone: Callable[[str], str]
    contents: tuple[Callable[[str], str], ...]
    listing: str | None = None


@dataclass(frozen=True)
class RecordStore(TenantData, ABC, Generic[RecordT]):
    """The stored records of one kind."""

    @property
    @abstractmethod
    def layout(self) -> Layout[RecordT]:
        """Where the records are."""

    @property
    def quotas(self) -> Quotas:
        """The tenant's quota."""
        return self._part(Quotas)

    def get(self, record_id: str) -> RecordT | None:
        """Return a record, or None if it does not exist."""
        return self._read(self.client.get(self.layout.record(record_id)))

    def use(self, record_id: str) -> RecordT | None:
        """Return a record, and extend its life."""
        with self.client.pipeline() as pipe:
            pipe.get(self.layout.record(record_id))
            self._extend(record_id, pipe)
            data = pipe.execute()[0]
        return self._read(data)

    def lost(self, record_id: str) -> bool:
        """Whether the blob store has lost bytes of a record."""
        return self.blobs.lost(self._bytes_of(record_id))

    def expired(self, record_id: str) -> bool:
        """Whether a record that does not exist has expired (and was not deleted)."""
        return bool(self.client.exists(self.layout.tombstone(record_id)))

    def wait_for_disk(self, record_id: str) -> None:
        """Wait as :meth:`Durability.wait` does until a record is on the disk."""
        self.durability.wait(self.layout.record(record_id))

    def delete(self, record_id: str) -> bool:
        """Delete a record with its bytes; False if it did not exist."""
        names = self._bytes_of(record_id)
        with self.client.pipeline() as pipe:
            pipe.delete(self.layout.record(record_id))
            for name in names:
                self.blobs.look_up(name, pipe)
            pipe.delete(self.layout.tombstone(record_id))
            self._unlist(record_id, pipe)
            self.blobs.unlink(names, pipe)
            existed, *stored = pipe.execute(raise_on_error=False)
        self.blobs.discard(zip(names, stored, strict=False))
        return bool(existed)

    def _page(
        self,
        key: str,
        limit: int,
        cursor: str | None,
        matches: Callable[[RecordT], bool] = lambda record: True,
    ) -> Page[RecordT]:
        listing = Listing(self.client, key, self.layout.record)
        fetch = partial(readable_records, self.client, self.layout.model, key=self.layout.record)
        return listing.page(limit, cursor, fetch, matches)

    def _accept(
        self,
        record: RecordT,
        stored: Mapping[str, BlobReference],
        file_type: str,
        job_id: str,
        admit: Callable[[Pipeline], None],
    ) -> None:
        """Store a record in place of a job's candidate, all at once.

        Parameters
        ----------
        record
            The record.
        stored
            References to its bytes by key.
        file_type, job_id
            Those of the candidate.
        admit
            Watches the candidate, and refuses the record if the tenant has too much.
        """
        key = self.keys.candidate(record.id, file_type, job_id)

        def attempt(pipe: Pipeline) -> None:
            admit(pipe)
            pipe.multi()
            self.blobs.look_up(key, pipe)
            for name, reference in stored.items():
                self.blobs.link(name, reference, pipe)
            self._put(record, pipe)
            self._extend(record.id, pipe)
            delete_candidate(self.keys, record.id, file_type, job_id, pipe)

        try:
            # Repeated if the candidate is gone, or the tenant got something else meanwhile.
            validated, *_ = cast(list[object], self.client.transaction(attempt))
        except QuotaExceeded:
            self.blobs.discard(stored.items())
            raise
        self.blobs.discard([(key, validated)])

    def _put(self, record: RecordT, pipe: Pipeline) -> None:
        pipe.set(self.layout.record(record.id), record.model_dump_json())
        pipe.set(self.layout.tombstone(record.id), b"")
        if self.layout.listing is not None:
            pipe.zadd(self.layout.listing, {record.id: record.created.timestamp()})

    def _unlist(self, record_id: str, pipe: Pipeline) -> None:
        if self.layout.listing is not None:
            pipe.zrem(self.layout.listing, record_id)

    def _extend(self, record_id: str, pipe: Pipeline) -> None:
        ttl = self.settings.shape_ttl
        for key in (self.layout.record, *self.layout.contents):
            pipe.expire(key(record_id), ttl)
        pipe.expire(self.layout.tombstone(record_id), ttl + self.settings.trace_ttl)

    def _bytes_of(self, record_id: str) -> list[str]:
        return [key(record_id) for key in self.layout.contents]

    def _read(self, data: str | bytes | None) -> RecordT | None:
        return None if data is None else read_record(self.layout.model, data)
