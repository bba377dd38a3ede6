"""Shapes in Redis: the record, the uploaded bytes, and the mesh as it was read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from redis.client import Pipeline

from broker.contracts import ShapeRecord
from broker.store import keys, scripts
from broker.store.listings import Listing, Page
from broker.store.records import read_record
from broker.store.uploads import Uploads

_MOMENT: Final = 60
"""Seconds for which a candidate is kept at least that is about to be a shape."""


@dataclass(frozen=True)
class Shapes(Uploads):
    """The stored shapes, and those that are being validated."""

    def get(self, shape_id: str) -> ShapeRecord | None:
        """Return the record of a shape, or None if there is no such shape."""
        data = self.client.get(keys.shape(shape_id))
        return None if data is None else read_record(ShapeRecord, data)

    def use(self, shape_id: str) -> ShapeRecord | None:
        """Return the record of a shape as :meth:`get`, and keep the shape for longer."""
        data = self._used(shape_id, keys.shape(shape_id))
        return None if data is None else read_record(ShapeRecord, data)

    def records(self, shape_ids: Sequence[str]) -> list[ShapeRecord | None]:
        """Return the records of several shapes, None for each that there is not."""
        found = self.client.mget([keys.shape(shape_id) for shape_id in shape_ids])
        return [None if data is None else read_record(ShapeRecord, data) for data in found]

    def upload(self, shape_id: str) -> bytes | None:
        """Return the bytes a shape was uploaded as, and keep the shape for longer."""
        return self._used(shape_id, keys.shape_upload(shape_id))

    def mesh(self, shape_id: str) -> bytes | None:
        """Return the mesh of a shape as it was read, npz, and keep the shape for longer."""
        return self._used(shape_id, keys.shape_mesh(shape_id))

    def geometry(self, shape_id: str) -> bytes | None:
        """Return the mesh of a shape as it is looked at, in gzip, and keep the shape for longer."""
        return self._used(shape_id, keys.shape_geometry(shape_id))

    def expired(self, shape_id: str) -> bool:
        """Whether a shape that is not there was there, and nobody deleted it."""
        return bool(self.client.exists(keys.shape_trace(shape_id)))

    def page(self, limit: int, cursor: str | None) -> Page[ShapeRecord]:
        """Return one page of all shapes, the newest first.

        Raises
        ------
        InvalidCursor
            The cursor is not one that a page gave.
        """
        listing = Listing(self.client, keys.SHAPES, keys.shape)
        return listing.page(limit, cursor, self.get)

    def delete(self, shape_id: str) -> bool:
        """Delete a shape; False if there was none."""
        with self.client.pipeline() as pipe:
            pipe.delete(keys.shape(shape_id))
            pipe.delete(keys.shape_upload(shape_id), keys.shape_mesh(shape_id))
            pipe.delete(keys.shape_geometry(shape_id))
            pipe.delete(keys.shape_trace(shape_id))
            pipe.zrem(keys.SHAPES, shape_id)
            return bool(pipe.execute()[0])

    def accept(self, record: ShapeRecord, mesh: bytes, geometry: bytes, job_id: str) -> bool:
        """Make a shape of a job's candidate, all at once; False if that is gone."""
        candidate = keys.candidate(record.id, record.file_type, job_id)
        # Should this process die now, another one still finds it.
        if not self.client.expire(candidate, max(self.settings.candidate_ttl, _MOMENT)):
            return False
        with self.client.pipeline() as pipe:
            pipe.eval(scripts.TAKE_UPLOAD, 2, candidate, keys.shape_upload(record.id))
            pipe.set(keys.shape_mesh(record.id), mesh)
            pipe.set(keys.shape_geometry(record.id), geometry)
            pipe.set(keys.shape(record.id), record.model_dump_json())
            pipe.set(keys.shape_trace(record.id), b"")
            self._keep(record.id, pipe)
            pipe.zadd(keys.SHAPES, {record.id: record.created.timestamp()})
            self.release(record.id, record.file_type, job_id, pipe)
            pipe.execute()
        return True

    def _used(self, shape_id: str, key: str) -> bytes | None:
        with self.client.pipeline() as pipe:
            pipe.get(key)
            self._keep(shape_id, pipe)
            reply: bytes | None = pipe.execute()[0]
            return reply

    def _keep(self, shape_id: str, pipe: Pipeline) -> None:
        ttl = self.settings.shape_ttl
        for key in (keys.shape, keys.shape_upload, keys.shape_mesh, keys.shape_geometry):
            pipe.expire(key(shape_id), ttl)
        pipe.expire(keys.shape_trace(shape_id), ttl + self.settings.trace_ttl)
