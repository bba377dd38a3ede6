"""Shapes: the record, the uploaded bytes, the mesh, and the geometry for the page."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import BinaryIO, Final

from redis import Redis
from redis.client import Pipeline
from redis.exceptions import WatchError

from broker.contracts import ShapeRecord
from broker.store.blobs import Blobs
from broker.store.connections import StoreSettings
from broker.store.keys import DEFAULT_KEYS, Keys
from broker.store.listings import Listing, Page
from broker.store.quotas import QuotaExceeded, Quotas
from broker.store.records import read_record, readable_records
from broker.store.uploads import CandidateGone, delete_candidate, watch_candidate

_ACCEPT_SECONDS: Final = 60
"""Seconds for which an accepted candidate is kept at least, until it is a shape."""


@dataclass(frozen=True)
class Shapes:
    """The stored shapes.

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

    def get(self, shape_id: str) -> ShapeRecord | None:
        """Return the record of a shape, or None if it does not exist."""
        return _record(self.client.get(self.keys.shape(shape_id)))

    def use(self, shape_id: str) -> ShapeRecord | None:
        """Return the record of a shape, and extend its life."""
        (record,) = self.use_all([shape_id])
        return record

    def use_all(self, shape_ids: Sequence[str]) -> list[ShapeRecord | None]:
        """Return the records of several shapes, one or more, and extend their lives."""
        with self.client.pipeline() as pipe:
            pipe.mget([self.keys.shape(shape_id) for shape_id in shape_ids])
            for shape_id in shape_ids:
                self._extend(shape_id, pipe)
            found = pipe.execute()[0]
        return [_record(data) for data in found]

    def records(self, shape_ids: Sequence[str]) -> list[ShapeRecord | None]:
        """Return the records of several shapes, None for each that does not exist."""
        found = self.client.mget([self.keys.shape(shape_id) for shape_id in shape_ids])
        return [_record(data) for data in found]

    def upload(self, shape_id: str) -> bytes | None:
        """Return the uploaded bytes of a shape, and extend its life."""
        return self._used(shape_id, self.keys.shape_upload(shape_id))

    def open_upload(self, shape_id: str) -> BinaryIO | None:
        """Return the uploaded bytes of a shape as a file, and extend its life."""
        self.use(shape_id)
        return self.blobs.open(self.keys.shape_upload(shape_id))

    def mesh(self, shape_id: str) -> bytes | None:
        """Return the mesh of a shape, npz, and extend its life."""
        return self._used(shape_id, self.keys.shape_mesh(shape_id))

    def geometry(self, shape_id: str) -> bytes | None:
        """Return the geometry of a shape for the page, gzip, and extend its life."""
        return self._used(shape_id, self.keys.shape_geometry(shape_id))

    def lost(self, shape_id: str) -> bool:
        """Whether the blob store has lost bytes of a shape."""
        return self.blobs.lost(self._bytes_of(shape_id))

    def expired(self, shape_id: str) -> bool:
        """Whether a shape that does not exist has expired (and was not deleted)."""
        return bool(self.client.exists(self.keys.shape_tombstone(shape_id)))

    def page(self, limit: int, cursor: str | None) -> Page[ShapeRecord]:
        """Return one page of all shapes, the newest first.

        Raises
        ------
        InvalidCursor
            No page has this cursor.
        """
        listing = Listing(self.client, self.keys.shapes, self.keys.shape)
        fetch = partial(readable_records, self.client, ShapeRecord, key=self.keys.shape)
        return listing.page(limit, cursor, fetch)

    def delete(self, shape_id: str) -> bool:
        """Delete a shape; False if it did not exist."""
        names = self._bytes_of(shape_id)
        with self.client.pipeline() as pipe:
            pipe.delete(self.keys.shape(shape_id))
            for name in names:
                self.blobs.look_up(name, pipe)
            pipe.delete(self.keys.shape_tombstone(shape_id))
            pipe.zrem(self.keys.shapes, shape_id)
            self.blobs.unlink(names, pipe)
            existed, *stored = pipe.execute(raise_on_error=False)
        self.blobs.discard(zip(names, stored, strict=False))
        return bool(existed)

    def accept(
        self, record: ShapeRecord, upload: bytes, mesh: bytes, geometry: bytes, job_id: str
    ) -> None:
        """Store a shape made of a job's candidate, all at once.

        Parameters
        ----------
        record
            Its record.
        upload, mesh, geometry
            The bytes of the candidate, of the repaired mesh (npz), and of what the page draws.
        job_id
            The job that validated the candidate, which is deleted.

        Raises
        ------
        CandidateGone
            It has expired, was rejected, or has been stored.
        QuotaExceeded
            The tenant has as many shapes or bytes as it may have.
        """
        candidate = self.keys.candidate(record.id, record.file_type, job_id)
        # If this process dies now, the repeated job must still find the candidate.
        if not self.client.expire(candidate, max(self.settings.candidate_ttl, _ACCEPT_SECONDS)):
            raise CandidateGone
        contents = zip(self._bytes_of(record.id), (upload, mesh, geometry), strict=True)
        stored = self.blobs.put_all(dict(contents))
        # The candidate has been counted, and is deleted.
        size = sum(reference.size for reference in stored.values()) - len(upload)
        with self.client.pipeline() as pipe:
            while True:
                try:
                    self._check_quota(record.id, size, pipe)
                    # It is gone, too, if only the reply to the transaction was lost: then the blobs
                    # are in use. Otherwise they are left to the sweep.
                    watch_candidate(candidate, pipe)
                    pipe.multi()
                    self.blobs.look_up(candidate, pipe)
                    for name, reference in stored.items():
                        self.blobs.link(name, reference, pipe)
                    pipe.set(self.keys.shape(record.id), record.model_dump_json())
                    pipe.set(self.keys.shape_tombstone(record.id), b"")
                    self._extend(record.id, pipe)
                    pipe.zadd(self.keys.shapes, {record.id: record.created.timestamp()})
                    delete_candidate(self.keys, record.id, record.file_type, job_id, pipe)
                    validated, *_ = pipe.execute()
                except WatchError:
                    # The candidate is gone, or the tenant got something else meanwhile.
                    continue
                except QuotaExceeded:
                    self.blobs.discard(stored.items())
                    raise
                self.blobs.discard([(candidate, validated)])
                return

    def _check_quota(self, shape_id: str, size: int, pipe: Pipeline) -> None:
        if self.get(shape_id) is None:
            Quotas(self.client, self.settings, self.keys).check(size, 1, pipe)

    def _used(self, shape_id: str, key: str) -> bytes | None:
        with self.client.pipeline() as pipe:
            self.blobs.look_up(key, pipe)
            self._extend(shape_id, pipe)
            reply, *_ = pipe.execute(raise_on_error=False)
        return self.blobs.read(key, reply)

    def _extend(self, shape_id: str, pipe: Pipeline) -> None:
        ttl = self.settings.shape_ttl
        for key in (
            self.keys.shape,
            self.keys.shape_upload,
            self.keys.shape_mesh,
            self.keys.shape_geometry,
        ):
            pipe.expire(key(shape_id), ttl)
        pipe.expire(self.keys.shape_tombstone(shape_id), ttl + self.settings.trace_ttl)

    def _bytes_of(self, shape_id: str) -> list[str]:
        return [
            self.keys.shape_upload(shape_id),
            self.keys.shape_mesh(shape_id),
            self.keys.shape_geometry(shape_id),
        ]


def _record(data: str | bytes | None) -> ShapeRecord | None:
    return None if data is None else read_record(ShapeRecord, data)
