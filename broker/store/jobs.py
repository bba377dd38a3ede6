"""Jobs in Redis: the record, the five states and the only ways between them, the results.

::

    queued -> running -> succeeded | failed | cancelled
       ^         |
       +--lost---+        (the process is gone: again, or failed after too often)
    queued -> cancelled

Each way is one script (:mod:`broker.store.scripts`): a state that is an end never changes, and a
result is stored before anybody can see that the job has succeeded. A runner that was given up may
come back late; whatever it then says is refused, because the job is no longer held by it.
"""

import gzip
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from redis import Redis
from redis.client import Pipeline

from broker.contracts import Delivery, JobKind, JobRecord, JobState, Problem, Progress, subject_of
from broker.store import keys, scripts
from broker.store.connections import StoreSettings
from broker.store.listings import Listing, Page
from broker.store.records import NewerRecord, job_document, read_record
from broker.store.replies import blob, text

LISTED_KINDS = frozenset(kind for kind in JobKind if kind.has_result)
"""Kinds of jobs that users ask for; the others serve them and are not listed."""


@dataclass(frozen=True)
class Jobs:
    """The stored jobs.

    Parameters
    ----------
    client
        Connection to Redis.
    settings
        How long what is kept.
    """

    client: Redis
    settings: StoreSettings

    def create(self, record: JobRecord, pipe: Pipeline) -> None:
        """Store a new, queued job, as part of a transaction."""
        created = record.created.timestamp()
        fields: dict[bytes | bytearray | memoryview | str | int | float, str] = {
            "record": job_document(record),
            "kind": record.kind.value,
            "state": JobState.QUEUED.value,
            "stage": record.progress.stage,
            "fraction": str(record.progress.fraction),
            "trace": str(self.settings.trace_ttl),
        }
        if record.webhook is not None:
            fields["webhook"] = record.webhook.url
        if record.kind in LISTED_KINDS:
            fields["quota"] = keys.queued_by(record.caller)
        pipe.hset(keys.job(record.id), mapping=fields)
        ttl = self.settings.job_ttl + self.settings.trace_ttl
        pipe.set(keys.job_trace(record.id), b"", ex=ttl)
        pipe.hincrby(keys.TALLIES, f"submitted|{record.kind.value}", 1)
        pipe.zadd(keys.ACTIVE_JOBS, {record.id: created})
        if record.kind in LISTED_KINDS:
            pipe.zadd(keys.JOBS, {record.id: created})
            pipe.zadd(keys.jobs_in(JobState.QUEUED), {record.id: created})
            for name in subject_of(record.payload).named:
                pipe.zadd(keys.jobs_of(name), {record.id: created})
                pipe.zremrangebyscore(keys.jobs_of(name), "-inf", created - ttl)
                pipe.expire(keys.jobs_of(name), ttl)

    def get(self, job_id: str) -> JobRecord | None:
        """Return a job as it is now, or None if there is no such job (any more).

        Raises
        ------
        NewerRecord
            A newer version asked for it, or ran it, with what this one does not know.
        """
        fields = self.client.hgetall(keys.job(job_id))
        return _record(fields) if b"record" in fields else None

    def readable(self, job_id: str) -> JobRecord | None:
        """Return a job as :meth:`get` does, or None if it cannot be read."""
        try:
            return self.get(job_id)
        except NewerRecord:
            return None

    def expired(self, job_id: str) -> bool:
        """Whether a job that is not there was there."""
        return bool(self.client.exists(keys.job_trace(job_id)))

    def state(self, job_id: str) -> JobState | None:
        """Return only the state of a job."""
        state = self.client.hget(keys.job(job_id), "state")
        return None if state is None else JobState(text(state))

    def page(
        self,
        limit: int,
        cursor: str | None,
        state: JobState | None = None,
        kind: JobKind | None = None,
        of: str | None = None,
    ) -> Page[JobRecord]:
        """Return one page of the listed jobs, the newest first.

        Parameters
        ----------
        limit
            How many there may be on it.
        cursor
            Of the page before; None for the first.
        state, kind
            Only those in this state, and of this kind.
        of
            Only those of this shape or prototype.

        Raises
        ------
        InvalidCursor
            The cursor is not one that a page gave.
        """

        def suits(record: JobRecord) -> bool:
            return state in (None, record.state) and kind in (None, record.kind)

        key = keys.JOBS if state is None else keys.jobs_in(state)
        listing = Listing(self.client, key if of is None else keys.jobs_of(of), keys.job)
        return listing.page(limit, cursor, self.get, suits)

    def active(self) -> Iterator[JobRecord]:
        """Go through all jobs that have not ended and can be read."""
        members: list[bytes] = self.client.zrange(keys.ACTIVE_JOBS, 0, -1)  # type: ignore[assignment]
        for job_id in map(text, members):
            try:
                record = self.get(job_id)
            except NewerRecord:
                continue  # versions that can read it look after it
            if record is None or record.state.ended:
                self.client.zrem(keys.ACTIVE_JOBS, job_id)
            else:
                yield record

    def claim(self, job_id: str, runner: str) -> bool:
        """Begin a queued job; False if it is not to be run, or not by this runner."""
        answer = self._script(scripts.CLAIM, job_id, runner, _now())
        return answer == [b"running", runner.encode()]

    def succeed(self, job_id: str, runner: str, result: bytes | None = None) -> bool:
        """End a job with its result (plain JSON); False if the runner no longer holds it."""
        packed = b"" if result is None else gzip.compress(result, compresslevel=6, mtime=0)
        return self._finish(job_id, runner, JobState.SUCCEEDED, result=packed)

    def fail(self, job_id: str, runner: str, problem: Problem) -> bool:
        """End a job with the reason of its failure; False if the runner no longer holds it."""
        return self._finish(job_id, runner, JobState.FAILED, error=problem.model_dump_json())

    def leave(self, job_id: str, runner: str) -> bool:
        """End a cancelled job; False if the runner no longer holds it."""
        return self._finish(job_id, runner, JobState.CANCELLED)

    def cancel(self, job_id: str) -> JobState | None:
        """Cancel a queued job, or ask a running one to leave; the state it is in then."""
        answer = self._script(scripts.CANCEL, job_id, _now(), self.settings.job_ttl)
        return _state(answer)

    def lose(self, job_id: str, losses_allowed: int, reason: Problem) -> JobState | None:
        """Note that the process of a job is gone; the state the job is in then.

        It is queued again at most `losses_allowed` times, then it has failed for `reason`; it is
        cancelled if that was asked.
        """
        answer = self._script(
            scripts.LOSE,
            job_id,
            _now(),
            self.settings.job_ttl,
            losses_allowed,
            reason.model_dump_json(),
        )
        return _state(answer)

    def report(self, job_id: str, runner: str, progress: Progress) -> bool:
        """Note progress; False when the job is cancelled or no longer held by this runner."""
        answer = self.client.eval(
            scripts.PROGRESS, 1, keys.job(job_id), runner, progress.stage, str(progress.fraction)
        )
        return bool(answer)

    def wanted(self, job_id: str, runner: str) -> bool:
        """Whether a job is still to be worked on by this runner."""
        state, holder, cancel = self.client.hmget(keys.job(job_id), ["state", "runner", "cancel"])
        held = holder is not None and text(holder) == runner
        return held and state == b"running" and cancel is None

    def cancel_requested(self, job_id: str) -> datetime | None:
        """Return when a running job was asked to leave, if it was."""
        asked = self.client.hget(keys.job(job_id), "cancel")
        return None if asked is None else datetime.fromisoformat(text(asked))

    def result(self, job_id: str) -> bytes | None:
        """Return the result of a job, JSON in gzip."""
        return blob(self.client.get(keys.job_result(job_id)))

    def picture(self, job_id: str, alternative: int | None = None) -> bytes | None:
        """Return the picture of a job's result, or of one of its alternatives, PNG."""
        return blob(self.client.get(keys.job_picture(job_id, alternative)))

    def set_picture(self, job_id: str, alternative: int | None, picture: bytes) -> None:
        """Store such a picture for as long as the result itself."""
        left = self.client.ttl(keys.job_result(job_id))
        if left > 0:
            self.client.set(keys.job_picture(job_id, alternative), picture, ex=left)

    def arrays(self, job_id: str) -> bytes | None:
        """Return the result of a job as arrays, npz."""
        return blob(self.client.get(keys.job_arrays(job_id)))

    def set_arrays(self, job_id: str, arrays: bytes) -> None:
        """Store the result of a job as arrays, before the result itself."""
        self.client.set(keys.job_arrays(job_id), arrays, ex=self.settings.result_ttl)

    def picture_job(self, drawn: str, alternative: int | None, job_id: str) -> str:
        """Return the job that draws a picture: `job_id`, or one that came first and goes on."""
        key = keys.picture_job(drawn, alternative)
        if self.client.set(key, job_id, nx=True, ex=self.settings.candidate_ttl):
            return job_id
        holder = text(self.client.get(key))
        state = None if holder is None else self.state(holder)
        if holder is not None and state is not None and not state.ended:
            return holder
        self.client.set(key, job_id, ex=self.settings.candidate_ttl)
        return job_id

    def _finish(
        self, job_id: str, runner: str, state: JobState, error: str = "", result: bytes = b""
    ) -> bool:
        answer = self._script(
            scripts.FINISH,
            job_id,
            runner,
            _now(),
            self.settings.job_ttl,
            state.value,
            error,
            result,
            self.settings.result_ttl,
        )
        return _state(answer) is state

    def _script(self, script: str, job_id: str, *arguments: str | bytes | int) -> object:
        names = [keys.job(job_id), keys.ACTIVE_JOBS]
        names += [keys.jobs_in(state) for state in JobState]
        names += [keys.TALLIES, keys.WEBHOOKS, keys.job_result(job_id)]
        values: Sequence[str | bytes | int] = [job_id, *arguments]
        return self.client.eval(script, len(names), *names, *values)


def _record(reply: dict[bytes | str, bytes | str]) -> JobRecord:
    fields = {text(name): text(value) for name, value in reply.items()}
    asked = read_record(JobRecord, fields["record"])
    try:
        return asked.model_copy(update=_present(fields))
    except ValueError as error:
        raise NewerRecord(JobRecord) from error


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
