"""The queue: submission of jobs, RQ's queues, the workers."""

from broker.queue.fair_queue import FairQueue
from broker.queue.new_jobs import new_job
from broker.queue.rq_queues import tenant_of
from broker.queue.settings import QUEUES, QueueSettings
from broker.queue.submission import JobQueue
from broker.queue.workers import WORKER_TIMEOUT, depths, longest_wait, worker_states

__all__ = [
    "QUEUES",
    "WORKER_TIMEOUT",
    "FairQueue",
    "JobQueue",
    "QueueSettings",
    "depths",
    "longest_wait",
    "new_job",
    "tenant_of",
    "worker_states",
]
