"""Runs operations over blocking I/O; the only module that knows how the sync client waits."""

import json
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, closing
from importlib.metadata import version
from typing import Any, TypedDict, TypeVar

import httpx2

from isomatch._http.exchange import (
    Call,
    Heard,
    Listen,
    NextLine,
    Operation,
    Pause,
    Stream,
    persistently,
)
from isomatch._models import Page

ResultT = TypeVar("ResultT")

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})


class ClientArguments(TypedDict):
    """Keyword arguments of httpx2's clients, sync and async alike."""

    base_url: str
    headers: dict[str, str]
    trust_env: bool


def client_arguments(base_url: str, api_key: str | None) -> ClientArguments:
    """Return the arguments of a client of one service."""
    headers = {"user-agent": f"isomatch/{version('isomatch')}"}
    if api_key is not None:
        headers["authorization"] = f"Bearer {api_key}"
    # A proxy from the environment cannot reach this machine's own services.
    trust_env = httpx2.URL(base_url).host not in LOOPBACK
    return {"base_url": base_url, "headers": headers, "trust_env": trust_env}


def request_arguments(call: Call, timeout: float | None) -> dict[str, Any]:
    """Return a call as the keyword arguments of ``build_request``, sync and async alike."""
    arguments: dict[str, Any] = {
        "method": call.method,
        "url": call.path,
        "params": {key: value for key, value in call.query.items() if value is not None},
        "timeout": None if timeout is None else timeout + call.patience,
        "headers": dict(call.headers),
    }
    if call.body is not None:
        arguments["content"] = json.dumps(call.body, allow_nan=False).encode()
        arguments["headers"] = {**call.headers, "content-type": "application/json"}
    if call.file is not None:
        arguments["files"] = {"file": (call.file.name, call.file.content)}
        arguments["data"] = dict(call.form)
    return arguments


def advance(operation: Generator[Any, Any, Any], outcome: object) -> Any:
    """Tell an operation what came of its last step, and return its next one."""
    if isinstance(outcome, Exception):
        return operation.throw(outcome)
    return operation.send(outcome)


class BlockingTransport:
    """Runs operations against one service, in the calling thread.

    Parameters
    ----------
    base_url
        Address of the service, with any path prefix.
    timeout
        Seconds without any progress after which a request fails; None for no limit.
    retries
        How often a request is repeated at most.
    transport
        Carries the requests instead of the network.
    api_key
        Sent with every request, where the service asks for one.
    """

    def __init__(
        self,
        base_url: str,
        timeout: float | None,
        retries: int,
        transport: httpx2.BaseTransport | None,
        api_key: str | None,
    ) -> None:
        self._timeout = timeout
        self.retries = retries
        self._http = httpx2.Client(transport=transport, **client_arguments(base_url, api_key))

    def run(self, operation: Operation[ResultT]) -> ResultT:
        """Do what the operation asks until it returns."""
        persistent, outcome = persistently(operation, self.retries), None
        try:
            while True:
                outcome = self._outcome(advance(persistent, outcome))
        except StopIteration as end:
            result: ResultT = end.value
            return result
        finally:
            persistent.close()

    def stream(self, operation: Stream[ResultT]) -> Generator[ResultT]:
        """Do what the operation asks, and go through what it hears."""
        lines: Iterator[str] = iter(())
        outcome: object = None
        with closing(operation), ExitStack() as listening:
            while True:
                try:
                    step = advance(operation, outcome)
                except StopIteration:
                    return
                if isinstance(step, Heard):
                    yield step.what
                    outcome = None
                elif isinstance(step, Listen):
                    listening.close()
                    outcome = self._outcome(step.call, stream=True)
                    if isinstance(outcome, httpx2.Response):
                        listening.enter_context(closing(outcome))
                        lines = outcome.iter_lines()
                elif isinstance(step, NextLine):
                    outcome = _line(lines)
                else:
                    outcome = self._outcome(step)

    def pages(self, ask: Callable[[str | None], Operation[Page[ResultT]]]) -> Iterator[ResultT]:
        """Go through all items of a listing, asking for page after page."""
        page = self.run(ask(None))
        yield from page.items
        while page.next_cursor is not None:
            page = self.run(ask(page.next_cursor))
            yield from page.items

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def _outcome(
        self, step: Call | Pause, stream: bool = False
    ) -> httpx2.Response | httpx2.TransportError | None:
        if isinstance(step, Pause):
            time.sleep(step.seconds)
            return None
        request = self._http.build_request(**request_arguments(step, self._timeout))
        try:
            response = self._http.send(request, stream=stream)
            if stream and not response.is_success:
                response.read()
        except httpx2.TransportError as error:
            return error
        return response


def _line(lines: Iterator[str]) -> str | httpx2.TransportError | None:
    try:
        return next(lines, None)
    except httpx2.TransportError as error:
        return error
