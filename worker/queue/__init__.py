"""The queues: which there are, what waits in them, and the way in."""

from worker.queue.records import new_job
from worker.queue.settings import QUEUES, QueueSettings
from worker.queue.submission import JobQueue

__all__ = ["QUEUES", "JobQueue", "QueueSettings", "new_job"]
