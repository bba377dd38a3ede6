"""Attribute files: the record and the uploaded bytes."""

from dataclasses import dataclass

from redis.client import Pipeline

from broker.contracts import AttributesRecord
from broker.store.record_store import Layout, RecordStore
from broker.store.uploads import watch_candidate


@dataclass(frozen=True)
class Attributes(RecordStore[AttributesRecord]):
    """The stored attribute files; they live as long as shapes."""

    @property
    def layout(self) -> Layout[AttributesRecord]:
        """Where the files are."""
        keys = self.keys
        return Layout(
            AttributesRecord, keys.attributes, keys.attributes_tombstone, (keys.attributes_file,)
        )

    def file(self, attributes_id: str) -> bytes | None:
        """Return the bytes of a file, and extend its life."""
        self.use(attributes_id)
        return self.blobs.get(self.keys.attributes_file(attributes_id))

    def accept(self, record: AttributesRecord, data: bytes, job_id: str) -> None:
        """Store a file made of a job's candidate, all at once.

        Raises
        ------
        CandidateGone
            It has expired, was rejected, or has been stored.
        QuotaExceeded
            The tenant has as many bytes as it may have.
        """
        stored = self.blobs.put_all({self.keys.attributes_file(record.id): data})

        def admit(pipe: Pipeline) -> None:
            # As for a shape, blobs of a candidate that is gone are left to the sweep.
            watch_candidate(self.keys.candidate(record.id, record.file_type, job_id), pipe)
            # Its bytes have been counted, as the candidate's.
            self.quotas.check(0, pipe=pipe)

        self._accept(record, stored, record.file_type, job_id, admit)
