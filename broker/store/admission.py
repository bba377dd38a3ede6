"""Admission of jobs: idempotency records of requests, and the callers' quotas of queued jobs."""

import time
from dataclasses import dataclass
from typing import Final

from redis import Redis
from redis.client import Pipeline

from broker.contracts import IdempotencyRecord
from broker.store import keys, scripts
from broker.store.replies import text

RESERVATION_SECONDS: Final = 60
"""Seconds for which a request may take to store the job whose id or place it has reserved."""


class KeyReused(ValueError):
    """An idempotency key was used for a different request before."""


class TooManyQueued(Exception):
    """A caller has as many jobs queued as it may have.

    Parameters
    ----------
    limit
        Number of jobs the caller may have queued.
    """

    def __init__(self, limit: int) -> None:
        super().__init__(f"{limit} jobs are queued already")
        self.limit = limit


@dataclass(frozen=True)
class Admission:
    """Idempotency records and quotas.

    Parameters
    ----------
    client
        Connection to Redis.
    """

    client: Redis

    def job_of(self, idempotency: IdempotencyRecord) -> str | None:
        """Return the job of an equal request, or None if there was no such request.

        Raises
        ------
        KeyReused
            The key was used for a different request.
        """
        noted = text(self.client.get(keys.idempotency_record(idempotency.name)))
        if noted is None:
            return None
        content, _, job_id = noted.partition(":")
        if content != idempotency.content:
            raise KeyReused("the idempotency key was used for a different request")
        return job_id

    def reserve(self, idempotency: IdempotencyRecord, job_id: str) -> str:
        """Return the id that the job of this request has or will have.

        Concurrent equal requests get the same id, and so make one job. The reservation expires
        soon if none of them does.

        Parameters
        ----------
        idempotency
            The request.
        job_id
            Id to reserve if this is the first such request.

        Raises
        ------
        KeyReused
            The key was used for a different request.
        """
        reserved = min(RESERVATION_SECONDS, idempotency.seconds)
        entry = f"{idempotency.content}:{job_id}"
        self.client.set(keys.idempotency_record(idempotency.name), entry, nx=True, ex=reserved)
        return self.job_of(idempotency) or job_id

    def remember(self, idempotency: IdempotencyRecord, job_id: str, pipe: Pipeline) -> None:
        """Store the record of a request and its job, as part of a transaction."""
        entry = f"{idempotency.content}:{job_id}"
        pipe.set(keys.idempotency_record(idempotency.name), entry, ex=idempotency.seconds)

    def bind(self, idempotency: IdempotencyRecord) -> None:
        """Store the record of a request that makes no job of its own.

        Raises
        ------
        KeyReused
            The key was used for a different request.
        """
        key, entry = keys.idempotency_record(idempotency.name), f"{idempotency.content}:"
        self.client.set(key, entry, nx=True, ex=idempotency.seconds)
        self.job_of(idempotency)

    def admit(self, caller: str | None, job_id: str, limit: int) -> None:
        """Count a job that is about to be stored towards its caller's quota.

        Parameters
        ----------
        caller
            Name of the caller's API key.
        job_id
            The job; it is counted once.
        limit
            Number of jobs the caller may have queued; 0 for no limit.

        Raises
        ------
        TooManyQueued
            The quota is used up.
        """
        queued = [keys.queued_by(caller)]
        arguments = job_id, time.time(), limit, keys.job(""), RESERVATION_SECONDS
        if not scripts.ADMIT_JOB(self.client, queued, *arguments):
            raise TooManyQueued(limit)
