"""Prototypes: the record, the archive, and the versions of each name."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from redis import Redis
from redis.client import Pipeline
from redis.exceptions import WatchError

from broker.contracts import ARCHIVE_TYPE, PrototypeRecord
from broker.store.blobs import BlobReference, Blobs
from broker.store.connections import StoreSettings
from broker.store.keys import DEFAULT_KEYS, Keys
from broker.store.listings import Listing, Page
from broker.store.quotas import QuotaExceeded, Quotas
from broker.store.records import read_record, readable_records
from broker.store.uploads import delete_candidate, watch_candidate


@dataclass(frozen=True)
class Prototypes:
    """The stored prototypes.

    A prototype is its archive: the same bytes are the same prototype, with the name and the version
    of their first upload. Another archive of that name is its next version.

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

    def get(self, prototype_id: str) -> PrototypeRecord | None:
        """Return the record of a prototype, or None if it does not exist."""
        data = self.client.get(self.keys.prototype(prototype_id))
        return None if data is None else read_record(PrototypeRecord, data)

    def use(self, prototype_id: str) -> PrototypeRecord | None:
        """Return the record of a prototype, and extend its life."""
        record = self.get(prototype_id)
        if record is not None:
            with self.client.pipeline() as pipe:
                self._extend(record, pipe)
                pipe.execute()
        return record

    def archive(self, prototype_id: str) -> bytes | None:
        """Return the archive of a prototype, npz, and extend its life."""
        self.use(prototype_id)
        return self.blobs.get(self.keys.prototype_archive(prototype_id))

    def geometry(self, prototype_id: str) -> bytes | None:
        """Return the points and a surface of a prototype, JSON in gzip, and keep it for longer."""
        self.use(prototype_id)
        return self.blobs.get(self.keys.prototype_geometry(prototype_id))

    def lost(self, prototype_id: str) -> bool:
        """Whether the blob store has lost bytes of a prototype."""
        return self.blobs.lost(self._bytes_of(prototype_id))

    def expired(self, prototype_id: str) -> bool:
        """Whether a prototype that does not exist has expired (and was not deleted)."""
        return bool(self.client.exists(self.keys.prototype_tombstone(prototype_id)))

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

        listing = Listing(self.client, key, self.keys.prototype)
        fetch = partial(readable_records, self.client, PrototypeRecord, key=self.keys.prototype)
        return listing.page(limit, cursor, fetch, matches)

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
        with self.client.pipeline() as pipe:
            while True:
                pipe.watch(key, self.keys.prototype_versions(name), *parts)
                for candidate in candidates:
                    watch_candidate(candidate, pipe)
                known = self.get(record.id)
                last = int(self.client.get(self.keys.prototype_versions(name)) or 0)
                is_lost = known is None or self.lost(record.id)
                stored = known or record.model_copy(update={"version": last + 1})
                try:
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
                    self._extend(stored, pipe)
                    if job_id is not None:
                        delete_candidate(self.keys, record.id, ARCHIVE_TYPE, job_id, pipe)
                    validated = pipe.execute()
                except WatchError:
                    # Another prototype of this name, or the same, was stored meanwhile.
                    continue
                break
        self.blobs.discard(zip(candidates, validated, strict=False))
        return stored

    def _check_quota(
        self, parts: Mapping[str, BlobReference], candidate: bytes, pipe: Pipeline
    ) -> None:
        # The candidate has been counted, and is deleted.
        size = sum(reference.size for reference in parts.values()) - len(candidate)
        try:
            Quotas(self.client, self.settings, self.keys).check(size, pipe=pipe)
        except QuotaExceeded:
            self.blobs.discard(parts.items())
            raise

    def delete(self, prototype_id: str) -> bool:
        """Delete a prototype; False if it did not exist. Its version is not used again."""
        record, names = self.get(prototype_id), self._bytes_of(prototype_id)
        with self.client.pipeline() as pipe:
            pipe.delete(self.keys.prototype(prototype_id))
            for name in names:
                self.blobs.look_up(name, pipe)
            pipe.delete(self.keys.prototype_tombstone(prototype_id))
            pipe.zrem(self.keys.prototypes, prototype_id)
            self.blobs.unlink(names, pipe)
            if record is not None:
                pipe.zrem(self.keys.prototypes_named(record.name), prototype_id)
            existed, *stored = pipe.execute(raise_on_error=False)
        self.blobs.discard(zip(names, stored, strict=False))
        return bool(existed)

    def _put(self, record: PrototypeRecord, pipe: Pipeline) -> None:
        created = record.created.timestamp()
        pipe.set(self.keys.prototype(record.id), record.model_dump_json())
        pipe.set(self.keys.prototype_tombstone(record.id), b"")
        pipe.set(self.keys.prototype_versions(record.name), record.version)
        pipe.zadd(self.keys.prototypes, {record.id: created})
        pipe.zadd(self.keys.prototypes_named(record.name), {record.id: created})

    def _extend(self, record: PrototypeRecord, pipe: Pipeline) -> None:
        ttl, longer = self.settings.shape_ttl, self.settings.shape_ttl + self.settings.trace_ttl
        for key in (self.keys.prototype, self.keys.prototype_archive, self.keys.prototype_geometry):
            pipe.expire(key(record.id), ttl)
        # What belongs to a name outlives the last prototype that has it.
        pipe.expire(self.keys.prototype_tombstone(record.id), longer)
        pipe.expire(self.keys.prototypes_named(record.name), longer)
        pipe.expire(self.keys.prototype_versions(record.name), longer)

    def _bytes_of(self, prototype_id: str) -> tuple[str, str]:
        return self.keys.prototype_archive(prototype_id), self.keys.prototype_geometry(prototype_id)
