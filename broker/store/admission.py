"""Admission of jobs: idempotency records of requests, and the limits of callers and tenants.

Validations of uploads have the same limits as jobs, and are counted apart: an upload, which ends
soon, needs not wait for jobs that take hours.
"""

import time
from dataclasses import dataclass
from typing import Final

from redis.client import Pipeline

from broker.contracts import IdempotencyRecord, JobRecord
from broker.store import scripts
from broker.store.replies import text
from broker.store.tenant_data import TenantData

RESERVATION_SECONDS: Final = 60
"""Seconds for which a request may take to store the job whose id or place it has reserved."""

_COUNTED_SECONDS: Final = 30 * 86400
"""Seconds for which a place is counted if no other is taken: longer than a job waits and runs."""


class KeyReused(ValueError):
    """An idempotency key was used for a different request before."""


class TooManyQueued(Exception):
    """A caller has as many jobs queued as it may have, or its tenant as many that have not ended.

    Parameters
    ----------
    record
        The job that is not admitted.
    limit
        Number of jobs, or of validations if it is one, the caller or the tenant may have.
    of_tenant
        Whether it is the tenant's limit.
    """

    def __init__(self, record: JobRecord, limit: int, of_tenant: bool = False) -> None:
        super().__init__(f"{limit} jobs are queued already")
        self.record, self.limit, self.of_tenant = record, limit, of_tenant


@dataclass(frozen=True)
class Admission(TenantData):
    """Idempotency records and quotas."""

    def job_of(self, idempotency: IdempotencyRecord) -> str | None:
        """Return the job of an equal request, or None if there was no such request.

        Raises
        ------
        KeyReused
            The key was used for a different request.
        """
        noted = text(self.client.get(self.keys.idempotency_record(idempotency.name)))
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
        self.client.set(self.keys.idempotency_record(idempotency.name), entry, nx=True, ex=reserved)
        return self.job_of(idempotency) or job_id

    def remember(self, idempotency: IdempotencyRecord, job_id: str, pipe: Pipeline) -> None:
        """Store the record of a request and its job, as part of a transaction."""
        entry = f"{idempotency.content}:{job_id}"
        pipe.set(self.keys.idempotency_record(idempotency.name), entry, ex=idempotency.seconds)

    def forget(self, idempotency: IdempotencyRecord, job_id: str) -> None:
        """Delete the record of a request if its job is still this one."""
        entry = f"{idempotency.content}:{job_id}"
        key = self.keys.idempotency_record(idempotency.name)
        scripts.RELEASE_LOCK(self.client, [key], entry)

    def bind(self, idempotency: IdempotencyRecord) -> None:
        """Store the record of a request that makes no job of its own.

        Raises
        ------
        KeyReused
            The key was used for a different request.
        """
        key, entry = self.keys.idempotency_record(idempotency.name), f"{idempotency.content}:"
        self.client.set(key, entry, nx=True, ex=idempotency.seconds)
        self.job_of(idempotency)

    def admit(self, record: JobRecord, limit: int, tenant_limit: int = 0) -> None:
        """Count a job that is about to be stored towards its caller's and its tenant's quota.

        Parameters
        ----------
        record
            The job; it is counted once.
        limit
            Number of jobs the caller may have queued; 0 for no limit.
        tenant_limit
            Number of jobs the tenant may have queued or running; 0 for no limit.

        Raises
        ------
        TooManyQueued
            The quota is used up.
        """
        limits = limit, tenant_limit
        times = RESERVATION_SECONDS, _COUNTED_SECONDS
        arguments = record.id, time.time(), *limits, self.keys.job(""), *times
        answer = scripts.ADMIT_JOB(self.client, list(self.keys.counted(record)), *arguments)
        if answer <= 0:
            reached = limit if answer == 0 else tenant_limit
            raise TooManyQueued(record, reached, of_tenant=answer < 0)

    def release(self, record: JobRecord) -> None:
        """Give back the place of an admitted job that will not be stored."""
        for key in self.keys.counted(record):
            self.client.zrem(key, record.id)
