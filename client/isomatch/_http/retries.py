"""Repetition of calls that failed or met a busy service, with exponential back-off."""

import math
import random
import time
from dataclasses import dataclass, field
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

LONGEST_OUTAGE: Final = 60.0
"""Seconds for which a service may be away, as while it restarts, before a wait for a job ends."""

_LONGEST_PAUSE_OF_OUTAGE: Final = 5.0
"""Longest pause before a service that is away is asked again, in seconds."""

_NEVER_SENT: Final = (httpx2.ConnectError, httpx2.ConnectTimeout, httpx2.PoolTimeout)
BUSY: Final = (429, 502, 503, 504)
"""Statuses of a service that is busy, or behind a proxy that does not reach it."""

_GONE: Final = (404, 410)
"""Statuses of a resource that does not exist, or no longer."""


@dataclass
class Failures:
    """Failures of a call in a row, and whether it may be repeated.

    Parameters
    ----------
    retries
        Greatest number of repetitions.
    outage
        Seconds since the first failure for which it is repeated nevertheless.
    deadline
        Time of `time.monotonic` from which it is not repeated.
    """

    retries: int
    outage: float = 0.0
    deadline: float = math.inf
    _count: int = field(default=0, init=False)
    _first: float = field(default=0.0, init=False)

    def clear(self) -> None:
        """Begin anew: the service has answered."""
        self._count = 0

    @property
    def repeated(self) -> bool:
        """Whether the present attempt is a repetition."""
        return self._count > 0

    def exhausted(self) -> bool:
        """Count a failure; true if it is the last one."""
        now = time.monotonic()
        if self._count == 0:
            self._first = now
        self._count += 1
        if now >= self.deadline:
            return True
        if self._count <= self.retries:
            return False
        return self.retries == 0 or now - self._first >= self.outage

    def pause(self, requested: float = 0.0) -> float:
        """Return the seconds to wait before the next attempt, `requested` or more if there are."""
        longest = LONGEST_PAUSE if self._count <= self.retries else _LONGEST_PAUSE_OF_OUTAGE
        wanted = max(requested, min(back_off(max(self._count - 1, 0)), longest))
        return min(wanted, max(self.deadline - time.monotonic(), 0.0))


def with_retries(operation: Operation[ResultT], retries: int) -> Operation[ResultT]:
    """Repeat the calls of an operation when the connection fails or the service is busy.

    A busy service (429, 502, 503, 504) is asked again after its ``Retry-After``, or after growing
    pauses.
    All calls are safe to repeat: those that create jobs have an idempotency key, and a repeated
    deletion that finds its resource gone has succeeded, as the first one may have been done.

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
    failures, sent = Failures(retries, call.outage, call.deadline), False
    while True:
        try:
            response = yield call
        except httpx2.TransportError as error:
            sent |= not isinstance(error, _NEVER_SENT)
            if failures.exhausted():
                failed = ConnectionFailed(failure_message(error, call))
                failed.sent = sent
                raise failed from error
            yield Pause(failures.pause())
        else:
            assert response is not None
            if call.deletes and failures.repeated and response.status_code in _GONE:
                return httpx2.Response(204, request=response.request)
            requested = retry_after(response) or 0.0
            if response.status_code not in BUSY or requested > LONGEST_PAUSE:
                return response
            if failures.exhausted():
                return response
            yield Pause(failures.pause(requested))


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
