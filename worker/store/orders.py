"""How jobs come in: each request once, and from each caller not too many."""

import time
from dataclasses import dataclass

from redis import Redis
from redis.client import Pipeline

from worker.contracts import Once
from worker.store import keys, scripts
from worker.store.replies import text


class KeyReused(ValueError):  # noqa: N818 - said of the key
    """An idempotency key came with another request than before."""


class TooManyQueued(Exception):  # noqa: N818 - said of the jobs
    """A caller has as many jobs queued as it may have.

    Parameters
    ----------
    limit
        How many that is.
    """

    def __init__(self, limit: int) -> None:
        super().__init__(f"{limit} jobs are queued already")
        self.limit = limit


@dataclass(frozen=True)
class Orders:
    """The requests that are remembered, and the places in the queue.

    Parameters
    ----------
    client
        Connection to Redis.
    """

    client: Redis

    def job_of(self, once: Once, pipe: Pipeline | None = None) -> str | None:
        """Return the job that an equal request made, or None if there was no such request.

        Parameters
        ----------
        once
            How the request is known.
        pipe
            A transaction that is to fail if the answer changes before it is executed.

        Raises
        ------
        KeyReused
            The key came with another request.
        """
        key = keys.order(once.name)
        if pipe is not None:
            pipe.watch(key)  # type: ignore[no-untyped-call]
        noted = text(self.client.get(key))
        if noted is None:
            return None
        content, _, job_id = noted.partition(":")
        if content != once.content:
            raise KeyReused("this key came with another request")
        return job_id

    def note(self, once: Once, job_id: str, pipe: Pipeline) -> None:
        """Remember a request and its job, as part of a transaction."""
        pipe.set(keys.order(once.name), f"{once.content}:{job_id}", ex=once.seconds)

    def bind(self, once: Once) -> None:
        """Remember a request that needs no job to be known again.

        Raises
        ------
        KeyReused
            The key came with another request.
        """
        self.client.set(keys.order(once.name), f"{once.content}:", nx=True, ex=once.seconds)
        self.job_of(once)

    def admit(self, caller: str | None, job_id: str, limit: int) -> None:
        """Take a place in the queue for a job that is about to be queued, unless it has one.

        Parameters
        ----------
        caller
            Whose job it is.
        job_id
            The job.
        limit
            How many jobs this caller may have queued; 0 for no limit.

        Raises
        ------
        TooManyQueued
            There is none left.
        """
        queued = keys.queued_by(caller)
        if not self.client.eval(scripts.ADMIT, 1, queued, job_id, time.time(), limit, keys.job("")):
            raise TooManyQueued(limit)

    def dismiss(self, caller: str | None, job_id: str) -> None:
        """Give the place of a job back that is not queued after all."""
        self.client.zrem(keys.queued_by(caller), job_id)
