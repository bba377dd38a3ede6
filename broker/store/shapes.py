"""Shapes: the record, the uploaded bytes, the mesh, and the geometry for the page."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO, Final

from redis.client import Pipeline

from broker.contracts import ShapeRecord
from broker.store.listings import Page
from broker.store.record_store import Layout, RecordStore
from broker.store.uploads import CandidateGone, watch_candidate

_ACCEPT_SECONDS: Final = 60
"""Seconds for which an accepted candidate is kept at least, until it is a shape."""


@dataclass(frozen=True)
class Shapes(RecordStore[ShapeRecord]):
    """The stored shapes."""

    @property
    def layout(self) -> Layout[ShapeRecord]:
        """Where the shapes are."""
        keys = self.keys
        contents = keys.shape_upload, keys.shape_mesh, keys.shape_geometry
        return Layout(ShapeRecord, keys.shape, keys.shape_tombstone, contents, keys.shapes)

    def use_all(self, shape_ids: Sequence[str]) -> list[ShapeRecord | None]:
        """Return the records of several shapes, one or more, and extend their lives."""
        with self.client.pipeline() as pipe:
            pipe.mget(list(map(self.keys.shape, shape_ids)))
            for shape_id in shape_ids:
                self._extend(shape_id, pipe)
            found = pipe.execute()[0]
        return list(map(self._read, found))

    def records(self, shape_ids: Sequence[str]) -> list[ShapeRecord | None]:
        """Return the records of several shapes, None for each that does not exist."""
        found = self.client.mget(list(map(self.keys.shape, shape_ids)))
        return list(map(self._read, found))

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

    def open_geometry(self, shape_id: str) -> BinaryIO | None:
        """Return the geometry of a shape for the page, gzip, as a file, and extend its life."""
        self.use(shape_id)
        return self.blobs.open(self.keys.shape_geometry(shape_id))

    def page(self, limit: int, cursor: str | None) -> Page[ShapeRecord]:
        """Return one page of all shapes, the newest first.

        Raises
        ------
        InvalidCursor
            No page has this cursor.
        """
        return self._page(self.keys.shapes, limit, cursor)

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
        validated = self.blobs.reference(candidate)
        # If this process dies now, the repeated job must still find the candidate.
        kept = self.client.expire(candidate, max(self.settings.candidate_ttl, _ACCEPT_SECONDS))
        if validated is None or not kept:
            raise CandidateGone
        contents = dict(zip(self._bytes_of(record.id), (upload, mesh, geometry), strict=True))
        digests = {self.keys.shape_upload(record.id): validated.digest}
        stored = self.blobs.put_all(contents, digests)
        # The candidate has been counted, and is deleted.
        size = sum(reference.size for reference in stored.values()) - len(upload)

        def admit(pipe: Pipeline) -> None:
            if self.get(record.id) is None:
                self.quotas.check(size, 1, pipe)
            # It is gone, too, if only the reply to the transaction was lost: then the blobs are in
            # use. Otherwise they are left to the sweep.
            watch_candidate(candidate, pipe)

        self._accept(record, stored, record.file_type, job_id, admit)

    def _used(self, shape_id: str, key: str) -> bytes | None:
        with self.client.pipeline() as pipe:
            self.blobs.look_up(key, pipe)
            self._extend(shape_id, pipe)
            reply, *_ = pipe.execute(raise_on_error=False)
        return self.blobs.read(key, reply)
