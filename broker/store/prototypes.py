"""Prototypes in Redis: the record, the archive, and the versions of each name."""

from dataclasses import dataclass

from redis.client import Pipeline
from redis.exceptions import WatchError

from broker.contracts import ARCHIVE_TYPE, PrototypeRecord
from broker.store import keys
from broker.store.listings import Listing, Page
from broker.store.records import read_record
from broker.store.replies import blob
from broker.store.uploads import Uploads


@dataclass(frozen=True)
class Prototypes(Uploads):
    """The stored prototypes, and those that are being validated.

    A prototype is its archive: the same bytes are the same prototype, under the name and of the
    version under which they were stored first. Another one of that name is its next version.
    """

    def get(self, prototype_id: str) -> PrototypeRecord | None:
        """Return the record of a prototype, or None if there is no such prototype."""
        data = self.client.get(keys.prototype(prototype_id))
        return None if data is None else read_record(PrototypeRecord, data)

    def use(self, prototype_id: str) -> PrototypeRecord | None:
        """Return the record of a prototype as :meth:`get`, and keep it for longer."""
        record = self.get(prototype_id)
        if record is not None:
            with self.client.pipeline() as pipe:
                self._keep(record, pipe)
                pipe.execute()
        return record

    def archive(self, prototype_id: str) -> bytes | None:
        """Return the archive of a prototype, npz, and keep the prototype for longer."""
        self.use(prototype_id)
        return blob(self.client.get(keys.prototype_archive(prototype_id)))

    def geometry(self, prototype_id: str) -> bytes | None:
        """Return the points and a surface of a prototype, JSON in gzip, and keep it for longer."""
        self.use(prototype_id)
        return blob(self.client.get(keys.prototype_geometry(prototype_id)))

    def expired(self, prototype_id: str) -> bool:
        """Whether a prototype that is not there was there, and nobody deleted it."""
        return bool(self.client.exists(keys.prototype_trace(prototype_id)))

    def page(
        self, limit: int, cursor: str | None, name: str | None = None
    ) -> Page[PrototypeRecord]:
        """Return one page of all prototypes, or of those of one name, the newest first.

        Raises
        ------
        InvalidCursor
            The cursor is not one that a page gave.
        """
        key = keys.PROTOTYPES if name is None else keys.prototypes_named(name)

        def suits(record: PrototypeRecord) -> bool:
            # One that has expired may have come again under another name.
            return name in (None, record.name)

        return Listing(self.client, key, keys.prototype).page(limit, cursor, self.get, suits)

    def add(
        self,
        record: PrototypeRecord,
        archive: bytes,
        geometry: bytes,
        job_id: str | None = None,
    ) -> PrototypeRecord:
        """Store a prototype, unless it is there already.

        Parameters
        ----------
        record
            What is known of it; the version is given here.
        archive
            The prototype.
        geometry
            Its points and a surface, `PrototypeGeometry` as JSON in gzip.
        job_id
            The job that validated it, if it was uploaded; its candidate is forgotten.

        Returns
        -------
        The record as it is stored, which may be that of an earlier time.
        """
        name, key = record.name, keys.prototype(record.id)
        with self.client.pipeline() as pipe:
            while True:
                pipe.watch(key, keys.prototype_versions(name))  # type: ignore[no-untyped-call]
                known = self.get(record.id)
                last = int(self.client.get(keys.prototype_versions(name)) or 0)
                stored = known or record.model_copy(update={"version": last + 1})
                try:
                    pipe.multi()
                    if known is None:
                        self._put(stored, archive, geometry, pipe)
                    self._keep(stored, pipe)
                    if job_id is not None:
                        pipe.delete(keys.candidate(record.id, ARCHIVE_TYPE, job_id))
                        self.release(record.id, ARCHIVE_TYPE, job_id, pipe)
                    pipe.execute()
                except WatchError:
                    # Another one of this name, or the same one, came in between.
                    continue
                return stored

    def delete(self, prototype_id: str) -> bool:
        """Delete a prototype; False if there was none. Its version is not given again."""
        record = self.get(prototype_id)
        with self.client.pipeline() as pipe:
            pipe.delete(keys.prototype(prototype_id))
            pipe.delete(keys.prototype_archive(prototype_id), keys.prototype_trace(prototype_id))
            pipe.delete(keys.prototype_geometry(prototype_id))
            pipe.zrem(keys.PROTOTYPES, prototype_id)
            if record is not None:
                pipe.zrem(keys.prototypes_named(record.name), prototype_id)
            return bool(pipe.execute()[0])

    def _put(
        self, record: PrototypeRecord, archive: bytes, geometry: bytes, pipe: Pipeline
    ) -> None:
        created = record.created.timestamp()
        pipe.set(keys.prototype_archive(record.id), archive)
        pipe.set(keys.prototype_geometry(record.id), geometry)
        pipe.set(keys.prototype(record.id), record.model_dump_json())
        pipe.set(keys.prototype_trace(record.id), b"")
        pipe.set(keys.prototype_versions(record.name), record.version)
        pipe.zadd(keys.PROTOTYPES, {record.id: created})
        pipe.zadd(keys.prototypes_named(record.name), {record.id: created})

    def _keep(self, record: PrototypeRecord, pipe: Pipeline) -> None:
        ttl, longer = self.settings.shape_ttl, self.settings.shape_ttl + self.settings.trace_ttl
        for key in (keys.prototype, keys.prototype_archive, keys.prototype_geometry):
            pipe.expire(key(record.id), ttl)
        # What belongs to a name outlives the last prototype that has it.
        pipe.expire(keys.prototype_trace(record.id), longer)
        pipe.expire(keys.prototypes_named(record.name), longer)
        pipe.expire(keys.prototype_versions(record.name), longer)
