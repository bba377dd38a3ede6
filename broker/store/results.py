"""Results of jobs in Redis: the document, the same as arrays, and pictures of it."""

from dataclasses import dataclass

from redis import Redis

from broker.contracts import JobState
from broker.store import keys
from broker.store.connections import StoreSettings
from broker.store.replies import blob, text


@dataclass(frozen=True)
class Results:
    """The stored results; :meth:`broker.store.Jobs.succeed` stores the document itself.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        Times to live.
    """

    client: Redis
    settings: StoreSettings

    def document(self, job_id: str) -> bytes | None:
        """Return the result of a job, JSON in gzip."""
        return blob(self.client.get(keys.job_result(job_id)))

    def arrays(self, job_id: str) -> bytes | None:
        """Return the result of a job as arrays, npz."""
        return blob(self.client.get(keys.job_arrays(job_id)))

    def set_arrays(self, job_id: str, arrays: bytes) -> None:
        """Store the result of a job as arrays, before the job succeeds."""
        self.client.set(keys.job_arrays(job_id), arrays, ex=self.settings.result_ttl)

    def picture(self, job_id: str, alternative: int | None = None) -> bytes | None:
        """Return the picture of a result, or of one of its alternatives, PNG."""
        return blob(self.client.get(keys.job_picture(job_id, alternative)))

    def set_picture(self, job_id: str, alternative: int | None, picture: bytes) -> None:
        """Store a picture for as long as the result itself."""
        left = self.client.ttl(keys.job_result(job_id))
        if left > 0:
            self.client.set(keys.job_picture(job_id, alternative), picture, ex=left)

    def picture_job(self, drawn: str, alternative: int | None, job_id: str) -> str:
        """Return the job that draws a picture: `job_id`, or an earlier one that has not ended."""
        key = keys.picture_job(drawn, alternative)
        if self.client.set(key, job_id, nx=True, ex=self.settings.candidate_ttl):
            return job_id
        holder = text(self.client.get(key))
        state = None if holder is None else text(self.client.hget(keys.job(holder), "state"))
        if holder is not None and state is not None and not JobState(state).ended:
            return holder
        self.client.set(key, job_id, ex=self.settings.candidate_ttl)
        return job_id
