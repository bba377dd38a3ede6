"""The queues: which there are, what waits in them, and the way in."""

from broker.queue.records import new_job
from broker.queue.settings import QUEUES, QueueSettings
from broker.queue.submission import JobQueue
from broker.queue.workforce import SILENCE, depths, worker_states

__all__ = ["QUEUES", "SILENCE", "JobQueue", "QueueSettings", "depths", "new_job", "worker_states"]
