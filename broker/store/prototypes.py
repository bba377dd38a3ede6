"""Prototypes: the record, the archive, and the versions of each name."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import BinaryIO, cast

from redis.client import Pipeline

from broker.contracts import ARCHIVE_TYPE, PrototypeRecord
from broker.store.blobs import BlobReference
from broker.store.listings import Page
from broker.store.quotas import QuotaExceeded
from broker.store.record_store import Layout, RecordStore
from broker.store.uploads import delete_candidate, watch_candidate


@dataclass(frozen=True)
class Prototypes(RecordStore[PrototypeRecord]):
    """The stored prototypes.

    A prototype is its archive: the same bytes are the same prototype, with the name and the version
    of their first upload. Another archive of that name is its next version, and no version is used
    again after a deletion.
    """

    @property
    def layout(self) -> Layout[PrototypeRecord]:
        """Where the prototypes are."""
        keys = self.keys
        contents = keys.prototype_archive, keys.prototype_geometry
        tombstone, listing = keys.prototype_tombstone, keys.prototypes
        return Layout(PrototypeRecord, keys.prototype, tombstone, contents, listing)

    def use(self, prototype_id: str) -> PrototypeRecord | None:
        """Return the record of a prototype, and extend its life."""
        record = self.get(prototype_id)
        if record is not None:
            with self.client.pipeline() as pipe:
                self._extend_all(record, pipe)
                pipe.execute()
        return record

    def archive(self, prototype_id: str) -> bytes | None:
        """Return the archive of a prototype, npz, and extend its life."""
        self.use(prototype_id)
        return self.blobs.get(self.keys.prototype_archive(prototype_id))

    def open_archive(self, prototype_id: str) -> BinaryIO | None:
        """Return the archive of a prototype, npz, as a file, and extend its life."""
        self.use(prototype_id)
        return self.blobs.open(self.keys.prototype_archive(prototype_id))

    def open_geometry(self, prototype_id: str) -> BinaryIO | None:
        """Return the points and a surface of a prototype, JSON in gzip, and extend its life."""
        self.use(prototype_id)
        return self.blobs.open(self.keys.prototype_geometry(prototype_id))

    def page(
        self, limit: int, cursor: str | None, name: str | None = None
    ) -> Page[PrototypeRecord]:
        """Return one page of all prototypes, or of those of one name, the newest first.

        Raises
        ------
        InvalidCursor
            No page has this cursor.
        """
        key = self.keys.prototypes if name is None else self.keys.prototypes_named(name)

        def matches(record: PrototypeRecord) -> bool:
            # An expired prototype may have been stored again under another name.
            return name in (None, record.name)

        return self._page(key, limit, cursor, matches)

    def add(
        self,
        record: PrototypeRecord,
        archive: bytes,
        geometry: bytes,
        job_id: str | None = None,
    ) -> PrototypeRecord:
        """Store a prototype, unless it exists already; lost bytes of it are restored.

        Parameters
        ----------
        record
            Its record; the version is set here.
        archive
            The prototype.
        geometry
            Its points and a surface, `PrototypeGeometry` as JSON in gzip.
        job_id
            The job that validated it, if it was uploaded; its candidate is deleted.

        Returns
        -------
        PrototypeRecord
            The record as it is stored, which may be an earlier one.

        Raises
        ------
        CandidateGone
            The candidate has expired, was rejected, or has been stored.
        QuotaExceeded
            The tenant has as many bytes as it may have.
        """
        name, key = record.name, self.keys.prototype(record.id)
        candidates = (
            [] if job_id is None else [self.keys.candidate(record.id, ARCHIVE_TYPE, job_id)]
        )
        # If they are not needed, they are left to the sweep: the record may be ours, of a
        # transaction whose reply was lost.
        contents = zip(self._bytes_of(record.id), (archive, geometry), strict=True)
        parts = self.blobs.put_all(dict(contents))
        stored = record

        def attempt(pipe: Pipeline) -> None:
            nonlocal stored
            pipe.watch(key, self.keys.prototype_versions(name), *parts)
            for candidate in candidates:
                watch_candidate(candidate, pipe)
            known = self.get(record.id)
            last = int(self.client.get(self.keys.prototype_versions(name)) or 0)
            is_lost = known is None or self.lost(record.id)
            stored = known or record.model_copy(update={"version": last + 1})
            if known is None:
                self._check_quota(parts, archive if candidates else b"", pipe)
            pipe.multi()
            for candidate in candidates:
                self.blobs.look_up(candidate, pipe)
            if known is None:
                self._put(stored, pipe)
            if is_lost:
                for part, reference in parts.items():
                    self.blobs.link(part, reference, pipe)
            self._extend_all(stored, pipe)
            if job_id is not None:
                delete_candidate(self.keys, record.id, ARCHIVE_TYPE, job_id, pipe)

        # Repeated if another prototype of this name, or the same, was stored meanwhile.
        validated = cast(list[object], self.client.transaction(attempt))
        self.blobs.discard(zip(candidates, validated, strict=False))
        return stored

    def _check_quota(
        self, parts: Mapping[str, BlobReference], candidate: bytes, pipe: Pipeline
    ) -> None:
        # The candidate has been counted, and is deleted.
        size = sum(reference.size for reference in parts.values()) - len(candidate)
        try:
            self.quotas.check(size, pipe=pipe)
        except QuotaExceeded:
            self.blobs.discard(parts.items())
            raise

    def _put(self, record: PrototypeRecord, pipe: Pipeline) -> None:
        super()._put(record, pipe)
        pipe.set(self.keys.prototype_versions(record.name), record.version)
        named = self.keys.prototypes_named(record.name)
        pipe.zadd(named, {record.id: record.created.timestamp()})

    def _unlist(self, record_id: str, pipe: Pipeline) -> None:
        super()._unlist(record_id, pipe)
        record = self.get(record_id)
        if record is not None:
            pipe.zrem(self.keys.prototypes_named(record.name), record_id)

    def _extend_all(self, record: PrototypeRecord, pipe: Pipeline) -> None:
        self._extend(record.id, pipe)
        # What belongs to a name outlives the last prototype that has it.
        longer = self.settings.shape_ttl + self.settings.trace_ttl
        pipe.expire(self.keys.prototypes_named(record.name), longer)
        pipe.expire(self.keys.prototype_versions(record.name), longer)
