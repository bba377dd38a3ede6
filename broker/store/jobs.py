"""Jobs: the record, the five states and the transitions between them.

::

    queued -> running -> succeeded | failed | cancelled
       ^         |
       +--lost---+        (the process died: queued again, or failed after too many losses)
    queued -> cancelled

Each transition is one script (:mod:`broker.store.scripts`): an end state never changes, and the
result is stored before the job is seen to have succeeded. A runner that was given up may come back
late; its calls are refused, because it no longer holds the job.
"""

import gzip
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final, TypeAlias, cast

from redis.client import Pipeline

from broker.contracts import (
    BatchPayload,
    Delivery,
    JobKind,
    JobRecord,
    JobState,
    Problem,
    Progress,
    Summary,
    subject_of,
)
from broker.store import scripts
from broker.store.keys import DEFAULT_KEYS, Keys
from broker.store.listings import Listing, Page
from broker.store.records import NewerRecord, job_document, read_record, readable
from broker.store.replies import text
from broker.store.scripts import LuaScript
from broker.store.tenant_data import TenantData
from broker.store.watching import kinds_and_states

_ACTIVE: Final = "state", "kind", "cancel"
"""Fields of an :class:`ActiveJob`."""

_Fields: TypeAlias = dict[bytes | str, bytes | str]

_SERVING_SECONDS: Final = 4 * 3600
"""Seconds for which the record of a job without a result is kept: an upload's validation, a picture
or another job that serves a request or a job. There may be many for each of those that are listed.
"""

_AT_A_TIME: Final = 500
"""Records that are read at a time."""


@dataclass(frozen=True)
class ActiveJob:
    """What recovery looks at of each job that has not ended.

    Parameters
    ----------
    id, kind, state
        As in its record.
    cancelled
        When it was asked to stop; None if it was not.
    """

    id: str
    kind: JobKind
    state: JobState
    cancelled: datetime | None


@dataclass(frozen=True)
class Jobs(TenantData):
    """The stored jobs."""

    def create(self, record: JobRecord, pipe: Pipeline) -> None:
        """Store a new, queued job, as part of a transaction."""
        created = record.created.timestamp()
        fields: dict[bytes | bytearray | memoryview | str | int | float, str] = {
            "record": job_document(record),
            "kind": record.kind.value,
            "state": JobState.QUEUED.value,
            "stage": record.progress.stage,
            "fraction": str(record.progress.fraction),
        }
        ttl = self.settings.job_ttl + self.settings.trace_ttl
        if record.kind.has_result:
            fields["trace"] = str(self.settings.trace_ttl)
            pipe.set(self.keys.job_tombstone(record.id), _matches(record) or "", ex=ttl)
        else:
            fields["kept"] = str(min(self.settings.job_ttl, _SERVING_SECONDS))
        if record.webhook is not None:
            fields["webhook"] = record.webhook.url
        if record.is_listed or record.is_upload:
            fields["quota"], _ = self.keys.counted(record)
        pipe.hset(self.keys.job(record.id), mapping=fields)
        pipe.hincrby(Keys.COUNTERS, f"submitted|{record.kind.value}", 1)
        pipe.zadd(self.keys.active_jobs, {record.id: created})
        if self.keys != DEFAULT_KEYS:
            pipe.sadd(Keys.TENANTS, self.keys.tenant)
        if record.is_listed:
            # It stays in Redis, which all tenants share, and may be as large as a request.
            size = len(fields["record"].encode())
            scripts.HOLD(pipe, [self.keys.held], self.keys.job(record.id), size)
            pipe.zadd(self.keys.jobs, {record.id: created})
            pipe.zadd(self.keys.jobs_in(JobState.QUEUED), {record.id: created})
            for name in subject_of(record.payload).named:
                pipe.zadd(self.keys.jobs_of(name), {record.id: created})
                pipe.zremrangebyscore(self.keys.jobs_of(name), "-inf", created - ttl)
                pipe.expire(self.keys.jobs_of(name), ttl)

    def get(self, job_id: str) -> JobRecord | None:
        """Return a job in its present state, or None if it does not exist (any more).

        Raises
        ------
        NewerRecord
            A newer version wrote something that this one does not know.
        """
        fields = self.client.hgetall(self.keys.job(job_id))
        return _record(fields) if b"record" in fields else None

    def records(self, job_ids: Sequence[str]) -> list[JobRecord | None]:
        """Return several jobs, each as :meth:`readable` does."""
        return [
            _readable(job_id, fields)
            for job_id, fields in zip(job_ids, self._fields(job_ids), strict=True)
        ]

    def readable(self, job_id: str) -> JobRecord | None:
        """Return a job as :meth:`get` does, or None if it cannot be read."""
        return self.records([job_id])[0]

    def exists(self, job_id: str) -> bool:
        """Return whether there is a record of a job, readable or not."""
        return bool(self.client.exists(self.keys.job(job_id)))

    def expired(self, job_id: str) -> bool:
        """Return whether a job that does not exist has expired."""
        return bool(self.client.exists(self.keys.job_tombstone(job_id)))

    def wait_for_disk(self, job_id: str) -> None:
        """Wait as :meth:`Durability.wait` does until a job is on the disk."""
        self.durability.wait(self.keys.job(job_id))

    def matches_of(self, batch: str) -> int:
        """Return the number of matches of a batch, which may have expired; 0 of other jobs."""
        return int(self.client.get(self.keys.job_tombstone(batch)) or 0)

    def state(self, job_id: str) -> JobState | None:
        """Return the state of a job."""
        state = self.client.hget(self.keys.job(job_id), "state")
        return None if state is None else JobState(text(state))

    def named_by(self, markers: Sequence[str]) -> list[str | None]:
        """Return the job that each of these keys names, None where it has ended or is gone.

        A job whose process was killed leaves its key.
        """
        named = [text(one) for one in self.client.mget(markers)] if markers else []
        with self.client.pipeline(transaction=False) as pipe:
            for job_id in named:
                pipe.hget(self.keys.job(job_id or ""), "state")
            states = pipe.execute()
        return [
            None if state is None or JobState(text(state)).ended else job_id
            for job_id, state in zip(named, states, strict=True)
        ]

    def page(
        self,
        limit: int,
        cursor: str | None,
        states: Collection[JobState] = (),
        kind: JobKind | None = None,
        of: str | None = None,
    ) -> Page[JobRecord]:
        """Return one page of the listed jobs, the newest first.

        Parameters
        ----------
        limit
            Largest number of jobs on it.
        cursor
            Cursor of the page before; None for the first.
        states, kind
            Only jobs in one of these states, if there are any, and of this kind.
        of
            Only jobs of this shape or prototype.

        Raises
        ------
        InvalidCursor
            No page has this cursor.
        """

        def matches(record: JobRecord) -> bool:
            return (not states or record.state in states) and kind in (None, record.kind)

        def may_match(names: Sequence[str]) -> list[bool]:
            # Records are read whole, and may be large.
            known = kinds_and_states(self, names)
            return [
                one is None or (kind in (None, one[0]) and (not states or one[1] in states))
                for one in known
            ]

        key = self.keys.jobs_in(*states) if len(states) == 1 else self.keys.jobs
        state = "+".join(sorted(states)) or None
        listing = Listing(self.client, key if of is None else self.keys.jobs_of(of), self.keys.job)
        filters = f"{state} {kind}"
        return listing.page(limit, cursor, self.records, matches, filters, may_match)

    def active(self) -> Iterator[ActiveJob]:
        """Iterate over all jobs that have not ended, of kinds and in states that are known."""
        members = cast(list[bytes], self.client.zrange(self.keys.active_jobs, 0, -1))
        for start in range(0, len(members), _AT_A_TIME):
            names = [text(member) for member in members[start : start + _AT_A_TIME]]
            keys = [self.keys.job(name) for name in names]
            found = scripts.JOB_FIELDS(self.client, keys, *_ACTIVE)
            for job_id, fields in zip(names, found, strict=True):
                job = None if fields is None else _active(job_id, text(fields))
                if fields is None or (job is not None and job.state.ended):
                    self.client.zrem(self.keys.active_jobs, job_id)
                elif job is not None:
                    yield job

    def active_of(self, names: Iterable[str]) -> list[JobRecord]:
        """Return the listed jobs of these shapes and prototypes that have not ended."""
        with self.client.pipeline(transaction=False) as pipe:
            for name in names:
                pipe.zinter([self.keys.jobs_of(name), self.keys.active_jobs])
            found = dict.fromkeys(text(member) for members in pipe.execute() for member in members)
        records = self.records(list(found))
        return [one for one in records if one is not None and not one.state.ended]

    def claim(self, job_id: str, runner: str) -> bool:
        """Start a queued job; False if it is not queued, or another runner was first."""
        answer = self._run(scripts.CLAIM_JOB, job_id, runner, _now())
        return answer == [b"running", runner.encode()]

    def succeed(
        self,
        job_id: str,
        runner: str,
        result: bytes | None = None,
        arrays: bytes | None = None,
        summary: Summary | None = None,
    ) -> bool:
        """End a job with its result, all at once; False if the runner no longer holds it.

        Of several calls for a job that is its own runner, one returns True.

        Parameters
        ----------
        job_id, runner
            The job, and who has run it.
        result, arrays
            The result, JSON; and the same as arrays, npz.
        summary
            The result in brief.
        """
        packed = None if result is None else gzip.compress(result, compresslevel=6, mtime=0)
        contents = {self.keys.job_result(job_id): packed, self.keys.job_arrays(job_id): arrays}
        stored = self.blobs.put_all({k: data for k, data in contents.items() if data is not None})
        result_blob, arrays_blob = (str(stored.get(key, "")) for key in contents)
        kept = self._finish(
            job_id,
            runner,
            JobState.SUCCEEDED,
            result=result_blob,
            arrays=arrays_blob,
            summary="" if summary is None else summary.model_dump_json(),
        )
        if not kept:
            self.blobs.discard(stored.items())
        return kept

    def fail(self, job_id: str, runner: str, problem: Problem) -> bool:
        """End a job with an error; False if the runner no longer holds it."""
        return self._finish(job_id, runner, JobState.FAILED, error=problem.model_dump_json())

    def finish_cancelled(self, job_id: str, runner: str) -> bool:
        """End a cancelled job; False if the runner no longer holds it."""
        return self._finish(job_id, runner, JobState.CANCELLED)

    def cancel(self, job_id: str) -> JobState | None:
        """Cancel a queued job, or ask a running one to stop; return its state then."""
        answer = self._run(scripts.CANCEL_JOB, job_id, _now(), self.settings.job_ttl)
        return _state(answer)

    def lose(
        self,
        job_id: str,
        losses_allowed: int,
        reason: Problem,
        runner: str | None = None,
        loss: str | None = None,
    ) -> JobState | None:
        """Record that the process of a job was lost; return the job's state then.

        It is queued again up to `losses_allowed` losses in all, then fails with `reason`; it is
        cancelled if that was requested. A job that a runner other than `runner` holds is left as it
        is; None stands for whichever holds it. A loss of the same name as the last one, `loss`, is
        not counted again: whoever recorded it failed before the job was back in the queue.
        """
        answer = self._run(
            scripts.LOSE_JOB,
            job_id,
            _now(),
            self.settings.job_ttl,
            losses_allowed,
            reason.model_dump_json(),
            runner or "",
            loss or "",
        )
        return _state(answer)

    def report(self, job_id: str, runner: str, progress: Progress) -> bool:
        """Store progress; False if the job is cancelled or no longer held by this runner."""
        said = runner, progress.stage, str(progress.fraction)
        return bool(scripts.REPORT_PROGRESS(self.client, [self.keys.job(job_id)], *said))

    def is_held(self, job_id: str, runner: str) -> bool:
        """Whether this runner holds a job that is running and not to be cancelled."""
        state, holder, cancel = self.client.hmget(
            self.keys.job(job_id), ["state", "runner", "cancel"]
        )
        held = holder is not None and text(holder) == runner
        return held and state == b"running" and cancel is None

    def _fields(self, job_ids: Sequence[str]) -> list[_Fields]:
        with self.client.pipeline(transaction=False) as pipe:
            for job_id in job_ids:
                pipe.hgetall(self.keys.job(job_id))
            return cast(list[_Fields], pipe.execute())

    def _finish(
        self,
        job_id: str,
        runner: str,
        state: JobState,
        error: str = "",
        result: str = "",
        arrays: str = "",
        summary: str = "",
    ) -> bool:
        answer = self._run(
            scripts.FINISH_JOB,
            job_id,
            runner,
            _now(),
            self.settings.job_ttl,
            state.value,
            error,
            self.settings.result_ttl,
            result,
            arrays,
            summary,
        )
        return answer == [state.value.encode(), runner.encode()]

    def _run(self, script: LuaScript, job_id: str, *arguments: str | bytes | int) -> object:
        names = [self.keys.job(job_id), self.keys.active_jobs]
        names += [self.keys.jobs_in(state) for state in JobState]
        names += [Keys.COUNTERS, self.keys.webhooks, self.keys.job_result(job_id)]
        names += [self.keys.held, self.keys.admitted]
        names += [self.keys.job_arrays(job_id), self.keys.job_summary(job_id)]
        names += [self.keys.validating]
        return script(self.client, names, job_id, *arguments)


def _matches(record: JobRecord) -> int:
    return len(record.payload.targets) if isinstance(record.payload, BatchPayload) else 0


def _record(reply: _Fields) -> JobRecord:
    fields = {text(name): text(value) for name, value in reply.items()}
    constant = read_record(JobRecord, fields["record"])
    try:
        return constant.model_copy(update=_present(fields))
    except ValueError as error:
        raise NewerRecord(JobRecord) from error


def _readable(job_id: str, fields: _Fields) -> JobRecord | None:
    if b"record" not in fields:
        return None
    return readable(JobRecord, job_id, lambda: _record(fields))


def _active(job_id: str, fields: str) -> ActiveJob | None:
    state, kind, cancelled = fields.split("\n")
    try:
        return ActiveJob(job_id, JobKind(kind), JobState(state), _time(cancelled or None))
    except ValueError:
        return None  # of a newer version, or damaged


def _present(fields: Mapping[str, str]) -> dict[str, object]:
    error, delivery = fields.get("error"), fields.get("delivery")
    return {
        "state": JobState(fields["state"]),
        "progress": Progress(stage=fields["stage"], fraction=float(fields["fraction"])),
        "started": _time(fields.get("started")),
        "ended": _time(fields.get("ended")),
        "error": None if error is None else Problem.model_validate_json(error),
        "delivery": None if delivery is None else Delivery.model_validate_json(delivery),
    }


def _state(answer: object) -> JobState | None:
    return JobState(text(answer)) if isinstance(answer, bytes | str) else None


def _time(value: str | None) -> datetime | None:
    return None if value is None else datetime.fromisoformat(value)


def _now() -> str:
    return datetime.now(UTC).isoformat()
