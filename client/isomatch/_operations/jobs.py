"""Operations that start, follow, list and cancel jobs."""

import math
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Final
from uuid import uuid4

import httpx2
from pydantic import ValidationError

from isomatch._errors import ConnectionFailed, UnexpectedResponse, WaitTimeout
from isomatch._http import (
    BUSY,
    LONGEST_OUTAGE,
    LONGEST_PAUSE,
    Call,
    EventReader,
    Failures,
    Item,
    Json,
    Listen,
    NextLine,
    Operation,
    Pause,
    Stream,
    checked_stream,
    failure_message,
    parsed,
    retry_after,
    send,
)
from isomatch._models import (
    DissimilarityParameters,
    JobRecord,
    MatchParameters,
    Shape,
    check_names,
)
from isomatch._operations.job_ids import beginning_explained
from isomatch._operations.outages import job_named
from isomatch._operations.request_parts import id_of, listed, named, names_of, path_to
from isomatch._results import Prototype
from isomatch._webhooks import Webhook

LONG_POLL: Final = 20.0
"""Seconds for which the service may hold back the answer about a running job."""

HEARTBEAT: Final = 15.0
"""Seconds after which the service sends something, if only to show that it is there."""

LONGEST_KEY: Final = 255
"""Characters of an idempotency key."""

LATENESS: Final = 1.0
"""Seconds that an answer which the service holds back until the end of a wait may come later."""

PROGRESS_POLL: Final = 0.5
"""Seconds between answers while a progress bar is shown, or if the service answers at once."""


def start_match(
    source: Shape | Prototype | str,
    target: Shape | str,
    *,
    parameters: MatchParameters,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue a match."""
    check_names(parameters, MatchParameters.__annotations__)
    body: dict[str, Json] = {
        "source": id_of(source),
        "target": id_of(target),
        **named(source_name=source, target_name=target),
    }
    return (yield from start_job("/v1/matches", body, parameters, webhook, key))


def start_dissimilarities(
    shapes: Iterable[Shape | str],
    labels: Iterable[str] | None,
    *,
    parameters: DissimilarityParameters,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue the comparison of a collection."""
    check_names(parameters, DissimilarityParameters.__annotations__, "dissimilarities")
    every = listed(shapes, "shapes")
    body: dict[str, Json] = {"shapes": [id_of(one) for one in every], "names": names_of(every)}
    if labels is not None:
        body["labels"] = [_label(one) for one in listed(labels, "labels")]
    return (yield from start_job("/v1/dissimilarities", body, parameters, webhook, key))


def _label(given: object) -> str:
    # NaN stands for missing labels in tables of pandas.
    if given is None or given != given:
        raise TypeError(f"give a label for each shape, not {given}")
    return str(given)


def start_consistent_maps(
    shapes: Iterable[Shape | str],
    *,
    largest_component: bool,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue the consistent maps of a collection."""
    every = listed(shapes, "shapes")
    body: dict[str, Json] = {"shapes": [id_of(one) for one in every], "names": names_of(every)}
    parameters = {"largest_component": largest_component}
    return (yield from start_job("/v1/consistent-maps", body, parameters, webhook, key))


def start_job(
    path: str,
    body: Mapping[str, Json],
    parameters: Mapping[str, object],
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue a job, once even if the request is repeated.

    Parameters
    ----------
    path
        Path of the collection of such jobs.
    body
        The request, without its parameters.
    parameters
        Parameters of the job.
    webhook
        Receiver of a notification when the job has ended.
    key
        Idempotency key; None for a new one.

    Raises
    ------
    TypeError, ValueError
        The key is not printable ASCII, or too long.
    """
    sent: dict[str, object] = {**body, **parameters}
    if webhook is not None:
        sent["webhook"] = webhook
    headers = {"idempotency-key": uuid4().hex if key is None else _key_given(key)}
    return parsed(JobRecord, (yield from send(Call("POST", path, body=sent, headers=headers))))


def _key_given(key: str) -> str:
    """Refuse a key that the service would refuse, or that no header can have."""
    if not isinstance(key, str):
        raise TypeError(f"idempotency_key must be a text, not {type(key).__name__}")
    if not (0 < len(key) <= LONGEST_KEY and key.isascii() and key.isprintable()):
        raise ValueError(f"idempotency_key must be printable ASCII, 1 to {LONGEST_KEY} characters")
    return key


def get_job(
    job_id: str, wait: float | None = None, outage: float = 0.0, deadline: float = math.inf
) -> Operation[JobRecord]:
    """Request a job, at once or when it has ended, but after at most `wait` seconds.

    The service may be away for `outage` seconds, until the time `deadline`.
    """
    path, query = path_to("jobs", job_id), {"wait": wait}
    patience = wait or 0.0
    call = Call("GET", path, query=query, patience=patience, outage=outage, deadline=deadline)
    with beginning_explained(id_of(job_id)):
        return parsed(JobRecord, (yield from send(call)))


def follow_job(job_id: str, retries: int) -> Stream[JobRecord]:
    """Yield the record of a job at each change until it has ended; broken streams are resumed.

    Parameters
    ----------
    job_id
        The job.
    retries
        Greatest number of failures in a row, unless they end within `LONGEST_OUTAGE`.

    Raises
    ------
    ConnectionFailed
        The service stayed away; the message names the job.
    """
    with job_named(job_id):
        yield from _followed(job_id, Failures(retries, LONGEST_OUTAGE))


def _followed(job_id: str, failures: Failures) -> Stream[JobRecord]:
    last = None
    while True:
        headers: dict[str, str] = {} if last is None else {"last-event-id": last}
        path = path_to("jobs", job_id, "events")
        call = Call("GET", path, headers=headers, patience=HEARTBEAT)
        reader = EventReader()
        try:
            response = yield Listen(call)
            assert isinstance(response, httpx2.Response)
            if response.status_code in BUSY and not failures.exhausted():
                requested = min(retry_after(response) or 0.0, LONGEST_PAUSE)
                yield Pause(failures.pause(requested))
                continue
            checked_stream(response)
            answered = False
            while isinstance(line := (yield NextLine()), str):
                failures.clear()
                answered = True
                if (event := reader.feed(line)) is not None:
                    last = event.id
                    record = _record_of(event.data, call)
                    yield Item(record)
                    if record.finished:
                        return
            if not answered:
                raise httpx2.RemoteProtocolError("no events came", request=response.request)
        except httpx2.TransportError as error:
            if failures.exhausted():
                raise ConnectionFailed(failure_message(error, call)) from error
        yield Pause(failures.pause())


def _record_of(document: str, call: Call) -> JobRecord:
    try:
        return JobRecord.model_validate_json(document)
    except ValidationError as error:
        where = ".".join(map(str, error.errors()[0]["loc"])) or "data"
        raise UnexpectedResponse(f"{call.path}: an event is not a job: {where}") from error


def cancel_job(job_id: str) -> Operation[JobRecord]:
    """Cancel a job."""
    return parsed(JobRecord, (yield from send(Call("DELETE", path_to("jobs", job_id)))))


def wait_for_job(
    job_id: str,
    timeout: float | None,
    update: Callable[[JobRecord], None],
    poll: float = LONG_POLL,
) -> Operation[None]:
    """Wait until a job has ended.

    Parameters
    ----------
    job_id
        The job.
    timeout
        Seconds to wait; None for no limit.
    update
        Called with every record that the service answers.
    poll
        Seconds between records, at most.

    Raises
    ------
    WaitTimeout
        The job did not end within `timeout` seconds, or the service did not answer in them.
    ConnectionFailed
        The service stayed away for `LONGEST_OUTAGE`; the message names the job.
    """
    limit = math.inf if timeout is None else timeout
    end = time.monotonic() + limit
    while True:
        asked = time.monotonic()
        left = max(end - asked, 0.0)
        wait, outage = round(min(left, poll), 3), min(left, LONGEST_OUTAGE)
        try:
            with job_named(job_id):
                record = yield from get_job(job_id, wait, outage, end + LATENESS)
        except ConnectionFailed as error:
            unanswered = isinstance(error.__cause__, httpx2.TimeoutException)
            if unanswered and time.monotonic() >= end:
                raise WaitTimeout(f"job {job_id}", limit, job_id) from error
            raise
        update(record)
        if record.finished:
            return
        now = time.monotonic()
        if now >= end:
            raise WaitTimeout(f"job {job_id}", limit, job_id)
        if (early := asked + wait - now) > 0.0:
            # A proxy, or a service that stops, may answer at once.
            yield Pause(min(early, PROGRESS_POLL))


def watch_job(
    job_id: str, timeout: float | None, update: Callable[[JobRecord], None]
) -> Operation[None]:
    """Wait until a job has ended, as :func:`wait_for_job`, with a progress bar."""
    # Imports rich, a third of the time that it takes to import this package.
    from isomatch._progress import ProgressBar

    with ProgressBar() as bar:

        def show(record: JobRecord) -> None:
            update(record)
            bar.update(record)

        yield from wait_for_job(job_id, timeout, show, PROGRESS_POLL)
