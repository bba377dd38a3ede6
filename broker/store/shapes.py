"""Shapes in Redis: the record, the uploaded bytes, the mesh, and the geometry for the page."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from redis import Redis
from redis.client import Pipeline

from broker.contracts import ShapeRecord
from broker.store import keys, scripts
from broker.store.connections import StoreSettings
from broker.store.listings import Listing, Page
from broker.store.records import read_record
from broker.store.uploads import delete_candidate

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
    """

    client: Redis
    settings: StoreSettings

    def get(self, shape_id: str) -> ShapeRecord | None:
        """Return the record of a shape, or None if it does not exist."""
        data = self.client.get(keys.shape(shape_id))
        return None if data is None else read_record(ShapeRecord, data)

    def use(self, shape_id: str) -> ShapeRecord | None:
        """Return the record of a shape, and extend its life."""
        data = self._used(shape_id, keys.shape(shape_id))
        return None if data is None else read_record(ShapeRecord, data)

    def records(self, shape_ids: Sequence[str]) -> list[ShapeRecord | None]:
        """Return the records of several shapes, None for each that does not exist."""
        found = self.client.mget([keys.shape(shape_id) for shape_id in shape_ids])
        return [None if data is None else read_record(ShapeRecord, data) for data in found]

    def upload(self, shape_id: str) -> bytes | None:
        """Return the uploaded bytes of a shape, and extend its life."""
        return self._used(shape_id, keys.shape_upload(shape_id))

    def mesh(self, shape_id: str) -> bytes | None:
        """Return the mesh of a shape, npz, and extend its life."""
        return self._used(shape_id, keys.shape_mesh(shape_id))

    def geometry(self, shape_id: str) -> bytes | None:
        """Return the geometry of a shape for the page, gzip, and extend its life."""
        return self._used(shape_id, keys.shape_geometry(shape_id))

    def expired(self, shape_id: str) -> bool:
        """Whether a shape that does not exist has expired (and was not deleted)."""
        return bool(self.client.exists(keys.shape_tombstone(shape_id)))

    def page(self, limit: int, cursor: str | None) -> Page[ShapeRecord]:
        """Return one page of all shapes, the newest first.

        Raises
        ------
        InvalidCursor
            No page has this cursor.
        """
        listing = Listing(self.client, keys.SHAPES, keys.shape)
        return listing.page(limit, cursor, self.get)

    def delete(self, shape_id: str) -> bool:
        """Delete a shape; False if it did not exist."""
        with self.client.pipeline() as pipe:
            pipe.delete(keys.shape(shape_id))
            pipe.delete(keys.shape_upload(shape_id), keys.shape_mesh(shape_id))
            pipe.delete(keys.shape_geometry(shape_id))
            pipe.delete(keys.shape_tombstone(shape_id))
            pipe.zrem(keys.SHAPES, shape_id)
            return bool(pipe.execute()[0])

    def accept(self, record: ShapeRecord, mesh: bytes, geometry: bytes, job_id: str) -> bool:
        """Store a shape made of a job's candidate, all at once; False if that has expired."""
        candidate = keys.candidate(record.id, record.file_type, job_id)
        # If this process dies now, the repeated job must still find the candidate.
        if not self.client.expire(candidate, max(self.settings.candidate_ttl, _ACCEPT_SECONDS)):
            return False
        with self.client.pipeline() as pipe:
            scripts.ACCEPT_UPLOAD(pipe, [candidate, keys.shape_upload(record.id)])
            pipe.set(keys.shape_mesh(record.id), mesh)
            pipe.set(keys.shape_geometry(record.id), geometry)
            pipe.set(keys.shape(record.id), record.model_dump_json())
            pipe.set(keys.shape_tombstone(record.id), b"")
            self._extend(record.id, pipe)
            pipe.zadd(keys.SHAPES, {record.id: record.created.timestamp()})
            delete_candidate(record.id, record.file_type, job_id, pipe)
            pipe.execute()
        return True

    def _used(self, shape_id: str, key: str) -> bytes | None:
        with self.client.pipeline() as pipe:
            pipe.get(key)
            self._extend(shape_id, pipe)
            reply: bytes | None = pipe.execute()[0]
            return reply

    def _extend(self, shape_id: str, pipe: Pipeline) -> None:
        ttl = self.settings.shape_ttl
        for key in (keys.shape, keys.shape_upload, keys.shape_mesh, keys.shape_geometry):
            pipe.expire(key(shape_id), ttl)
        pipe.expire(keys.shape_tombstone(shape_id), ttl + self.settings.trace_ttl)
