"""The states of the jobs whose changes are streamed, read for all streams together."""

import hashlib
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Self, TypeAlias, cast

from fastapi import Depends, Request

from broker.contracts import JobRecord
from broker.queue import JobQueue
from broker.store import NewerRecord, signs
from service.jobs.schemas import Job, depends_on_queue
from service.watcher import Watcher

Name: TypeAlias = tuple[str, str]
"""Tenant and id of a job."""


@dataclass(frozen=True)
class Event:
    """A state of a job.

    Attributes
    ----------
    id
        Digest of the state.
    data
        The job, JSON.
    last
        Whether the job has ended.
    """

    id: str
    data: str
    last: bool

    @classmethod
    def of(cls, job: Job) -> Self:
        """Return the event that tells of a job."""
        data = job.model_dump_json()
        return cls(hashlib.sha256(data.encode()).hexdigest()[:16], data, job.state.ended)


@dataclass
class _Known:
    sign: bytes | None
    record: JobRecord | None
    event: Event | None = None


class FollowedJobs:
    """Reads the present states of jobs; of their records only those that have changed.

    Parameters
    ----------
    queue
        The queue, of any tenant.
    """

    def __init__(self, queue: JobQueue) -> None:
        self._queue = queue
        self._known: dict[Name, _Known] = {}

    def __call__(self, names: Sequence[Name]) -> list[Event | None]:
        """Return the state of each job, None if it does not exist or cannot be read."""
        tenants = defaultdict(list)
        for tenant, job in names:
            tenants[tenant].append(job)
        self._known = {
            name: known
            for tenant, jobs in tenants.items()
            for name, known in self._of_tenant(tenant, jobs).items()
        }
        return [self._known[name].event for name in names]

    def _of_tenant(self, tenant: str, jobs: list[str]) -> dict[Name, _Known]:
        queue = self._queue.of(tenant)
        found = signs(queue.store, jobs)
        known: dict[Name, _Known] = {}
        changed: list[Name] = []
        for job, sign in zip(jobs, found, strict=True):
            name = tenant, job
            before = self._known.get(name)
            if sign is not None and before is not None and before.sign == sign:
                known[name] = before
            else:
                known[name] = _Known(sign, None)
                changed.append(name)
        records = queue.store.jobs.records([job for _, job in changed]) if changed else []
        for name, record in zip(changed, records, strict=True):
            one = known[name]
            one.record = record if one.sign is not None else _unqueued(name[1], queue)
        shown = [one for one in known.values() if _moves(one)]
        present = _presented([one.record for one in shown if one.record is not None], queue)
        for one, event in zip(shown, present, strict=True):
            one.event = event
        return known


def _unqueued(match: str, queue: JobQueue) -> JobRecord | None:
    """Return a match of a batch that has no record yet, or None if there is no such match."""
    try:
        return queue.job(match)
    except NewerRecord:
        return None


def _presented(records: Sequence[JobRecord], queue: JobQueue) -> list[Event | None]:
    try:
        return [Event.of(job) for job in Job.several(records, queue)]
    except (NewerRecord, ValueError):
        # The record of a shape cannot be read: that concerns only the streams of its jobs.
        if len(records) == 1:
            return [None]
        return [event for one in records for event in _presented([one], queue)]


def _moves(known: _Known) -> bool:
    """Whether the state of a job must be presented anew."""
    record = known.record
    return record is not None and (known.event is None or depends_on_queue(record))


async def _followed(request: Request) -> Watcher[Name, Event | None]:
    return cast(Watcher[Name, Event | None], request.state.followed)


FollowedOf = Annotated[Watcher[Name, Event | None], Depends(_followed)]
"""The jobs whose changes are streamed."""
