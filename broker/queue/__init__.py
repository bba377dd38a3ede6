"""The queues: submission of jobs, RQ's queues, the workers."""

from broker.queue.new_jobs import new_job
from broker.queue.settings import QUEUES, QueueSettings
from broker.queue.submission import JobQueue
from broker.queue.workers import WORKER_TIMEOUT, depths, worker_states

__all__ = [
    "QUEUES",
    "WORKER_TIMEOUT",
    "JobQueue",
    "QueueSettings",
    "depths",
    "new_job",
    "worker_states",
]
