"""Operations that start, follow, list and cancel jobs; see :mod:`isomatch._http.exchange`."""

import time
from collections.abc import Callable, Iterable, Mapping
from typing import Final
from uuid import uuid4

import httpx2
from pydantic import ValidationError

from isomatch._errors import (
    ConnectionFailed,
    ServiceUnavailable,
    TooManyRequests,
    UnexpectedResponse,
    WaitTimeout,
)
from isomatch._http import (
    LONGEST_PAUSE,
    Call,
    EventReader,
    Heard,
    Json,
    Listen,
    NextLine,
    Operation,
    Pause,
    Stream,
    back_off,
    checked,
    describe,
    parsed,
    send,
)
from isomatch._models import (
    DissimilarityParameters,
    JobRecord,
    JobState,
    MatchParameters,
    Page,
    Shape,
    check_names,
)
from isomatch._operations.request_parts import id_of, path_to, plain
from isomatch._progress import ProgressBar
from isomatch._results import Prototype
from isomatch._webhooks import Webhook

LONG_POLL: Final = 20.0
"""Seconds the service is asked to hold an answer back while a job goes on."""

WATCHED_POLL: Final = 0.5
"""The same while somebody looks at the progress."""


def start_match(
    source: Shape | Prototype | str,
    target: Shape | str,
    parameters: MatchParameters,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue a match; `key` makes it the same request when it is sent again."""
    check_names(parameters, MatchParameters.__annotations__)
    body: dict[str, Json] = {"source": id_of(source), "target": id_of(target)}
    for parameter, value in parameters.items():
        body[parameter] = plain(value)
    return (yield from start_job("/v1/matches", body, webhook, key))


def start_dissimilarities(
    shapes: Iterable[Shape | str],
    labels: Iterable[str] | None,
    parameters: DissimilarityParameters,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue the comparison of a collection; `key` makes it the same request when sent again."""
    check_names(parameters, DissimilarityParameters.__annotations__, "dissimilarities")
    body: dict[str, Json] = {"shapes": [id_of(shape) for shape in shapes]}
    if labels is not None:
        body["labels"] = [str(label) for label in labels]
    for parameter, value in parameters.items():
        body[parameter] = plain(value)
    return (yield from start_job("/v1/dissimilarities", body, webhook, key))


def start_job(
    path: str, body: Mapping[str, Json], webhook: Webhook | None, key: str | None
) -> Operation[JobRecord]:
    """Queue a job, once however often the request has to be sent.

    Parameters
    ----------
    path
        Where such jobs are asked for.
    body
        What is asked.
    webhook
        Whom to tell when the job has ended.
    key
        Idempotency key; None for one made up here.
    """
    if webhook is not None:
        body = {**body, "webhook": webhook}
    headers = {"idempotency-key": key or uuid4().hex}
    call = Call("POST", path, body=body, headers=headers)
    return parsed(JobRecord, (yield from send(call)))


def get_job(job_id: str, wait: float | None = None) -> Operation[JobRecord]:
    """Ask for one job, at once or when it has ended but at most `wait` seconds later."""
    call = Call("GET", path_to("jobs", job_id), query={"wait": wait}, patience=wait or 0.0)
    return parsed(JobRecord, (yield from send(call)))


def follow_job(job_id: str, retries: int) -> Stream[JobRecord]:
    """Hear of a job as it changes until it has ended; what breaks is taken up where it broke.

    Parameters
    ----------
    job_id
        The job.
    retries
        How often in a row the stream may fail before that is an error.
    """
    last, failures = None, 0
    while True:
        headers: dict[str, str] = {} if last is None else {"last-event-id": last}
        call, reader = (
            Call("GET", path_to("jobs", job_id, "events"), headers=headers),
            EventReader(),
        )
        asked = 0.0
        try:
            response = yield Listen(call)
            assert isinstance(response, httpx2.Response)
            checked(response)
            while isinstance(line := (yield NextLine()), str):
                if (event := reader.feed(line)) is not None:
                    last, failures = event.id, 0
                    record = _record_of(event.data, call)
                    yield Heard(record)
                    if record.finished:
                        return
        except (httpx2.TransportError, TooManyRequests, ServiceUnavailable) as error:
            failures += 1
            if failures > retries:
                if isinstance(error, httpx2.TransportError):
                    raise ConnectionFailed(describe(error, call)) from error
                raise
            if not isinstance(error, httpx2.TransportError):
                asked = min(error.retry_after or 0.0, LONGEST_PAUSE)
        yield Pause(max(asked, back_off(max(failures - 1, 0))))


def _record_of(document: str, call: Call) -> JobRecord:
    """Read what a stream of events says of a job.

    Raises
    ------
    UnexpectedResponse
        It says something else.
    """
    try:
        return JobRecord.model_validate_json(document)
    except ValidationError as error:
        where = ".".join(map(str, error.errors()[0]["loc"])) or "data"
        raise UnexpectedResponse(
            f"{call.path} tells of something that is no job: {where}"
        ) from error


def list_jobs(
    cursor: str | None,
    state: JobState | None,
    kind: str | None,
    of: Shape | Prototype | str | None,
) -> Operation[Page[JobRecord]]:
    """Request one page of the jobs, of all or of those of a state, a kind, a shape or prototype."""
    shape = None if of is None else id_of(of)
    query = {"state": state, "kind": kind, "shape": shape, "cursor": cursor}
    call = Call("GET", "/v1/jobs", query=query)
    return parsed(Page[JobRecord], (yield from send(call)))


def cancel_job(job_id: str) -> Operation[JobRecord]:
    """Cancel a job."""
    return parsed(JobRecord, (yield from send(Call("DELETE", path_to("jobs", job_id)))))


def wait_for_job(
    job_id: str,
    timeout: float | None,
    told: Callable[[JobRecord], None],
    watched: bool = False,
) -> Operation[None]:
    """Wait until a job has ended.

    Parameters
    ----------
    job_id
        The job.
    timeout
        Seconds to wait; None for as long as it takes.
    told
        Is told what the service says of the job, every time it says something.
    watched
        Whether somebody looks at the progress.

    Raises
    ------
    WaitTimeout
        It did not end within `timeout` seconds.
    """
    start = time.monotonic()
    poll = WATCHED_POLL if watched else LONG_POLL
    while True:
        left = poll if timeout is None else timeout - (time.monotonic() - start)
        record = yield from get_job(job_id, wait=round(min(max(left, 0.0), poll), 3))
        told(record)
        if record.finished:
            return
        if timeout is not None and time.monotonic() - start >= timeout:
            raise WaitTimeout(f"job {job_id}", timeout)


def watch_job(
    job_id: str, timeout: float | None, told: Callable[[JobRecord], None]
) -> Operation[None]:
    """Wait until a job has ended, with a progress bar; as :func:`wait_for_job` otherwise."""
    with ProgressBar() as bar:

        def shown(record: JobRecord) -> None:
            told(record)
            bar.update(record)

        yield from wait_for_job(job_id, timeout, shown, watched=True)
