"""How jobs come in: each request once, and from each caller not too many."""

import time
from dataclasses import dataclass
from typing import Final

from redis import Redis
from redis.client import Pipeline

from broker.contracts import Once
from broker.store import keys, scripts
from broker.store.replies import text

RESERVED_SECONDS: Final = 60
"""How long the id of a job is reserved that a request is about to make."""


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

    def job_of(self, once: Once) -> str | None:
        """Return the job of an equal request, or None if there was no such request.

        Raises
        ------
        KeyReused
            The key came with another request.
        """
        noted = text(self.client.get(keys.order(once.name)))
        if noted is None:
            return None
        content, _, job_id = noted.partition(":")
        if content != once.content:
            raise KeyReused("this key came with another request")
        return job_id

    def reserve(self, once: Once, job_id: str) -> str:
        """Return the id that the job of this request has or will have.

        Equal requests agree on it, so that those which come at the same time make one job. It is
        forgotten soon if none of them makes it.

        Parameters
        ----------
        once
            How the request is known.
        job_id
            Its id if this is the first such request.

        Raises
        ------
        KeyReused
            The key came with another request.
        """
        seconds = min(RESERVED_SECONDS, once.seconds)
        self.client.set(keys.order(once.name), f"{once.content}:{job_id}", nx=True, ex=seconds)
        return self.job_of(once) or job_id

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
        """Take a place in the queue for a job that is about to be stored, unless it has one.

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
