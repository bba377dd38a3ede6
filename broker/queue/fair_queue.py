"""A queue that tenants share fairly: each has its turn, however many jobs another has queued."""

from dataclasses import asdict, dataclass
from typing import Any, Final

from redis.client import Pipeline
from rq import Queue
from rq.job import Job

from broker.store.scripts import QUEUE_JOB

_TAGS_TTL: Final = 7 * 86400
"""Seconds after which the tags of a queue expire that gets no jobs."""

_SHARE: Final = "share"
"""Where in a job's `meta` its share stands; ``queue_job.lua`` reads it there."""


@dataclass(frozen=True)
class Share:
    """What a job counts in start-time fair queueing.

    Jobs of one flow are served in the order they came. While several flows have jobs waiting, each
    is served jobs of the same cost in sum, but for one job and the lead.

    Parameters
    ----------
    flow
        Name of the flow.
    cost
        What the job takes of its flow's share; positive, and the same for all jobs of a flow.
    lead
        How far a flow that was served little may come before the others, as a cost.
    """

    flow: str
    cost: float
    lead: float

    def meta(self) -> dict[str, Any]:
        """Return what the `meta` of RQ's job must contain."""
        return {_SHARE: asdict(self)}


class FairQueue(Queue):
    """A queue of RQ that puts each job where its share says, instead of at the end.

    Workers take jobs from its front as from any other queue. Jobs without a share count as one flow
    of cost 1.
    """

    @property
    def _tags(self) -> str:
        return f"{self.key}:tags"

    def push_job_id(
        self, job_id: str, pipeline: Pipeline | None = None, at_front: bool = False
    ) -> None:
        """Put a job, whose record RQ has stored, at its place, or before all others."""
        connection = self.connection if pipeline is None else pipeline
        if at_front:
            # It was served before: its flow has been charged, and its tag is no later than others.
            connection.lpush(self.key, job_id)
            return
        state = [self.key, self._tags, f"{self.key}:clock", Job.key_for(job_id)]
        QUEUE_JOB(connection, state, job_id, _TAGS_TTL)

    def withdraw(self, job: Job) -> None:
        """Delete a job that waits, for which its flow is not charged; leave one that was taken."""
        if not self.remove(job):
            return
        flow = job.get_meta(refresh=False).get(_SHARE, {}).get("flow", "")
        # A full Redis, such as 7.0, refuses all commands of a transaction.
        with self.connection.pipeline(transaction=False) as pipe:
            # Not `job.delete()`: it fails if a lost execution of the job is half expired.
            pipe.delete(job.key, job.execution_registry.key)
            pipe.zrem(self._tags, job.id)
            pipe.zrem(f"{self.key}:flow:{flow}", job.id)
            pipe.execute()
