"""Uploads: candidates, whose bytes wait for the job that validates them."""

from dataclasses import dataclass
from typing import BinaryIO

from redis.client import Pipeline

from broker.store import scripts
from broker.store.blobs import BlobReference
from broker.store.keys import Keys
from broker.store.replies import text
from broker.store.tenant_data import TenantData


class CandidateGone(Exception):
    """A job's candidate has expired, was rejected, or has been stored."""


@dataclass(frozen=True)
class Uploads(TenantData):
    """Uploads that are being validated, by the id of the shape or prototype they will become."""

    def put_candidate(
        self,
        upload_id: str,
        file_type: str,
        data: bytes | BinaryIO,
        job_id: str,
        digest: str | None = None,
    ) -> BlobReference:
        """Store uploaded bytes, of a SHA-256 if that is known, for the job that validates them."""
        return self.blobs.put(self.keys.candidate(upload_id, file_type, job_id), data, digest)

    def discard_candidate(
        self, upload_id: str, file_type: str, stored: BlobReference, job_id: str
    ) -> None:
        """Delete uploaded bytes that no job will validate."""
        self.blobs.discard([(self.keys.candidate(upload_id, file_type, job_id), stored)])

    def add_candidate(
        self,
        upload_id: str,
        file_type: str,
        stored: BlobReference,
        job_id: str,
        pipe: Pipeline,
    ) -> None:
        """Name uploaded bytes to the job that validates them, as part of a transaction."""
        ttl, key = self.settings.candidate_ttl, self.keys.candidate(upload_id, file_type, job_id)
        pipe.set(self.keys.candidate_job(upload_id, file_type), job_id, ex=ttl)
        self.blobs.link(key, stored, pipe)
        pipe.expire(key, ttl)

    def candidate(self, upload_id: str, file_type: str, job_id: str) -> bytes:
        """Return the uploaded bytes that a job validates.

        Raises
        ------
        CandidateGone
            They are not kept any more.
        """
        data = self.blobs.get(self.keys.candidate(upload_id, file_type, job_id))
        if data is None:
            raise CandidateGone
        return data

    def reject(self, upload_id: str, file_type: str, job_id: str) -> None:
        """Delete a job's candidate; an equal one that another job validates stays."""
        key = self.keys.candidate(upload_id, file_type, job_id)
        with self.client.pipeline() as pipe:
            self.blobs.look_up(key, pipe)
            delete_candidate(self.keys, upload_id, file_type, job_id, pipe)
            stored, *_ = pipe.execute(raise_on_error=False)
        self.blobs.discard([(key, stored)])

    def defer(self, upload_id: str, job_id: str) -> None:
        """Store the validation job of an upload whose response did not wait for it."""
        self.client.set(self.keys.deferred(upload_id), job_id, ex=self.settings.candidate_ttl)

    def deferred(self, upload_id: str) -> str | None:
        """Return the validation job of an upload whose response did not wait for it."""
        return text(self.client.get(self.keys.deferred(upload_id)))


def watch_candidate(key: str, pipe: Pipeline) -> None:
    """Let a transaction fail if a job's candidate is gone by then.

    Raises
    ------
    CandidateGone
        It is gone now.
    """
    pipe.watch(key)
    if not pipe.exists(key):  # sent at once, before the transaction
        raise CandidateGone


def delete_candidate(
    keys: Keys, upload_id: str, file_type: str, job_id: str, pipe: Pipeline
) -> None:
    """Delete a job's candidate, as part of a transaction."""
    key = keys.candidate(upload_id, file_type, job_id)
    pipe.delete(key)
    scripts.RELEASE(pipe, [keys.held], key)
    scripts.RELEASE_LOCK(pipe, [keys.candidate_job(upload_id, file_type)], job_id)
