"""Uploads on their way in Redis: bytes that wait for the job that says whether they are usable."""

from dataclasses import dataclass

from redis import Redis
from redis.client import Pipeline

from broker.store import keys, scripts
from broker.store.connections import StoreSettings
from broker.store.replies import blob, text


@dataclass(frozen=True)
class Uploads:
    """Uploads that are being validated, each by its id, which is that of what it will become.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        How long what is kept.
    """

    client: Redis
    settings: StoreSettings

    def validated_by(self, upload_id: str, file_type: str, pipe: Pipeline) -> str | None:
        """Return the job of an equal upload, if there is one, and watch whether that changes."""
        key = keys.candidate_job(upload_id, file_type)
        pipe.watch(key)  # type: ignore[no-untyped-call]
        return text(self.client.get(key))

    def add_candidate(
        self, upload_id: str, file_type: str, data: bytes, job_id: str, pipe: Pipeline
    ) -> None:
        """Keep uploaded bytes for the job that validates them, as part of a transaction."""
        ttl = self.settings.candidate_ttl
        pipe.set(keys.candidate_job(upload_id, file_type), job_id, ex=ttl)
        pipe.set(keys.candidate(upload_id, file_type, job_id), data, ex=ttl)

    def candidate(self, upload_id: str, file_type: str, job_id: str) -> bytes | None:
        """Return the uploaded bytes that a job is to validate."""
        return blob(self.client.get(keys.candidate(upload_id, file_type, job_id)))

    def reject(self, upload_id: str, file_type: str, job_id: str) -> None:
        """Forget a job's candidate; an equal one that another job validates stays."""
        with self.client.pipeline() as pipe:
            pipe.delete(keys.candidate(upload_id, file_type, job_id))
            self.release(upload_id, file_type, job_id, pipe)
            pipe.execute()

    def release(self, upload_id: str, file_type: str, job_id: str, pipe: Pipeline) -> None:
        """Note that a job validates an upload no more, as part of a transaction."""
        pipe.eval(scripts.RELEASE, 1, keys.candidate_job(upload_id, file_type), job_id)

    def defer(self, upload_id: str, job_id: str) -> None:
        """Remember the validation job of an upload whose sender was told to ask again."""
        self.client.set(keys.deferred(upload_id), job_id, ex=self.settings.candidate_ttl)

    def deferred(self, upload_id: str) -> str | None:
        """Return the validation job of an upload whose sender was told to ask again."""
        return text(self.client.get(keys.deferred(upload_id)))
