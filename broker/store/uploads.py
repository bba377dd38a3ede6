"""Uploads: candidates, whose bytes wait for the job that validates them."""

from dataclasses import dataclass

from redis import Redis
from redis.client import Pipeline

from broker.store import keys, scripts
from broker.store.blobs import BlobReference, Blobs
from broker.store.connections import StoreSettings
from broker.store.replies import text


@dataclass(frozen=True)
class Uploads:
    """Uploads that are being validated, by the id of the shape or prototype they will become.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        Times to live.
    blobs
        The bytes.
    """

    client: Redis
    settings: StoreSettings
    blobs: Blobs

    def validating_job(self, upload_id: str, file_type: str, pipe: Pipeline) -> str | None:
        """Return the job that validates an equal upload, if any, and watch its key."""
        key = keys.candidate_job(upload_id, file_type)
        pipe.watch(key)
        return text(self.client.get(key))

    def put_candidate(
        self, upload_id: str, file_type: str, data: bytes, job_id: str
    ) -> BlobReference:
        """Store uploaded bytes for the job that validates them."""
        return self.blobs.put(keys.candidate(upload_id, file_type, job_id), data)

    def add_candidate(
        self,
        upload_id: str,
        file_type: str,
        stored: BlobReference,
        job_id: str,
        pipe: Pipeline,
    ) -> None:
        """Name uploaded bytes to the job that validates them, as part of a transaction."""
        ttl, key = self.settings.candidate_ttl, keys.candidate(upload_id, file_type, job_id)
        pipe.set(keys.candidate_job(upload_id, file_type), job_id, ex=ttl)
        self.blobs.link(key, stored, pipe)
        pipe.expire(key, ttl)

    def candidate(self, upload_id: str, file_type: str, job_id: str) -> bytes | None:
        """Return the uploaded bytes that a job validates."""
        return self.blobs.get(keys.candidate(upload_id, file_type, job_id))

    def reject(self, upload_id: str, file_type: str, job_id: str) -> None:
        """Delete a job's candidate; an equal one that another job validates stays."""
        key = keys.candidate(upload_id, file_type, job_id)
        with self.client.pipeline() as pipe:
            self.blobs.look_up(key, pipe)
            delete_candidate(upload_id, file_type, job_id, pipe)
            stored, *_ = pipe.execute(raise_on_error=False)
        self.blobs.discard([(key, stored)])

    def defer(self, upload_id: str, job_id: str) -> None:
        """Store the validation job of an upload whose response did not wait for it."""
        self.client.set(keys.deferred(upload_id), job_id, ex=self.settings.candidate_ttl)

    def deferred(self, upload_id: str) -> str | None:
        """Return the validation job of an upload whose response did not wait for it."""
        return text(self.client.get(keys.deferred(upload_id)))


def delete_candidate(upload_id: str, file_type: str, job_id: str, pipe: Pipeline) -> None:
    """Delete a job's candidate, as part of a transaction."""
    pipe.delete(keys.candidate(upload_id, file_type, job_id))
    scripts.RELEASE_LOCK(pipe, [keys.candidate_job(upload_id, file_type)], job_id)
