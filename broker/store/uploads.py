"""Uploads in Redis: candidates, whose bytes wait for the job that validates them."""

from dataclasses import dataclass

from redis import Redis
from redis.client import Pipeline

from broker.store import keys, scripts
from broker.store.connections import StoreSettings
from broker.store.replies import blob, text


@dataclass(frozen=True)
class Uploads:
    """Uploads that are being validated, by the id of the shape or prototype they will become.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        Times to live.
    """

    client: Redis
    settings: StoreSettings

    def validating_job(self, upload_id: str, file_type: str, pipe: Pipeline) -> str | None:
        """Return the job that validates an equal upload, if any, and watch its key."""
        key = keys.candidate_job(upload_id, file_type)
        pipe.watch(key)
        return text(self.client.get(key))

    def add_candidate(
        self, upload_id: str, file_type: str, data: bytes, job_id: str, pipe: Pipeline
    ) -> None:
        """Store uploaded bytes for the job that validates them, as part of a transaction."""
        ttl = self.settings.candidate_ttl
        pipe.set(keys.candidate_job(upload_id, file_type), job_id, ex=ttl)
        pipe.set(keys.candidate(upload_id, file_type, job_id), data, ex=ttl)

    def candidate(self, upload_id: str, file_type: str, job_id: str) -> bytes | None:
        """Return the uploaded bytes that a job validates."""
        return blob(self.client.get(keys.candidate(upload_id, file_type, job_id)))

    def reject(self, upload_id: str, file_type: str, job_id: str) -> None:
        """Delete a job's candidate; an equal one that another job validates stays."""
        with self.client.pipeline() as pipe:
            delete_candidate(upload_id, file_type, job_id, pipe)
            pipe.execute()

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
