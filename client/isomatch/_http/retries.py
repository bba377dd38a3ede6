"""Repetition of calls that failed or met a busy service, with exponential back-off."""

import random
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Final, TypeVar

import httpx2

from isomatch._errors import ConnectionFailed
from isomatch._http.operation import Call, Operation, Pause

ResultT = TypeVar("ResultT")

FIRST_PAUSE: Final = 0.1
"""Seconds before the second attempt; each later pause is three times the one before."""

LONGEST_PAUSE: Final = 30.0
"""Longest pause between attempts, in seconds; a service that asks for a longer one is not asked
again."""

_NEVER_SENT: Final = (httpx2.ConnectError, httpx2.ConnectTimeout, httpx2.PoolTimeout)
_BUSY: Final = (429, 503)


def with_retries(operation: Operation[ResultT], retries: int) -> Operation[ResultT]:
    """Repeat the calls of an operation when the connection fails or the service is busy.

    A busy service (429, 503) is asked again after its ``Retry-After``, or after growing pauses.
    All calls of the API are safe to repeat: those that create jobs have an idempotency key.

    Parameters
    ----------
    operation
        The operation; :class:`ConnectionFailed` is thrown into it after the last attempt.
    retries
        Greatest number of repetitions of each call.
    """
    try:
        step = next(operation)
        while True:
            if isinstance(step, Pause):
                yield step
                step = operation.send(None)
                continue
            try:
                response = yield from _attempts(step, retries)
            except ConnectionFailed as error:
                step = operation.throw(error)
            else:
                step = operation.send(response)
    except StopIteration as end:
        result: ResultT = end.value
        return result
    finally:
        operation.close()


def _attempts(call: Call, retries: int) -> Operation[httpx2.Response]:
    for attempt in range(retries + 1):
        last = attempt == retries
        try:
            response = yield call
        except httpx2.TransportError as error:
            if last:
                raise ConnectionFailed(failure_message(error, call)) from error
            yield Pause(back_off(attempt))
        else:
            assert response is not None
            requested = retry_after(response) or 0.0
            if last or response.status_code not in _BUSY or requested > LONGEST_PAUSE:
                return response
            yield Pause(max(requested, back_off(attempt)))
    raise AssertionError("the last attempt returns or raises")


def back_off(attempt: int) -> float:
    """Return the seconds to wait after a failed attempt, the first being 0.

    They vary by a fifth, so that clients that failed together do not return together.
    """
    return min(FIRST_PAUSE * 3.0**attempt, LONGEST_PAUSE) * random.uniform(0.8, 1.2)


def retry_after(response: httpx2.Response) -> float | None:
    """Return the seconds of an answer's ``Retry-After`` header; None without one."""
    stated = response.headers.get("retry-after", "").strip()
    if stated.isdecimal():
        return float(stated)
    try:
        when = parsedate_to_datetime(stated)
    except ValueError:
        return None
    if when.tzinfo is None:
        return None
    return max((when - datetime.now(UTC)).total_seconds(), 0.0)


def failure_message(error: httpx2.TransportError, call: Call) -> str:
    """Return in one line why a call got no answer."""
    reason = str(error) or type(error).__name__
    url = error.request.url
    service = f"the isomatch service at {url.scheme}://{url.netloc.decode()}"
    if isinstance(error, _NEVER_SENT):
        return f"{service} cannot be reached: {reason}"
    if isinstance(error, httpx2.TimeoutException):
        return f"{service} did not answer {call.method} {call.path} in time"
    return f"the connection to {service} broke: {reason}"
