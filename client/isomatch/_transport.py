"""Runs operations over blocking I/O; the only module that knows how this client waits."""

import json
import time
from collections.abc import Generator
from importlib.metadata import version
from typing import TypeVar

import httpx2

from isomatch._exchange import Call, Operation, Pause, checked

ResultT = TypeVar("ResultT")

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})


def request_arguments(call: Call, timeout: float | None) -> dict[str, object]:
    """Return a call as the keyword arguments of ``build_request``, sync and async alike."""
    arguments: dict[str, object] = {
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


class BlockingTransport:
    """Runs operations against one service, in the calling thread.

    Parameters
    ----------
    base_url
        Address of the service, with any path prefix.
    timeout
        Seconds without any progress after which a request fails; None for no limit.
    transport
        Carries the requests instead of the network.
    api_key
        Sent with every request, where the service asks for one.
    """

    def __init__(
        self,
        base_url: str,
        timeout: float | None,
        transport: httpx2.BaseTransport | None,
        api_key: str | None = None,
    ) -> None:
        self._timeout = timeout
        self._http = httpx2.Client(
            base_url=base_url,
            transport=transport,
            headers=_headers(api_key),
            # A proxy from the environment cannot reach this machine's own services.
            trust_env=httpx2.URL(base_url).host not in LOOPBACK,
        )

    def run(self, operation: Operation[ResultT]) -> ResultT:
        """Do what the operation asks until it returns."""
        try:
            step = next(operation)
            while True:
                if isinstance(step, Pause):
                    time.sleep(step.seconds)
                    step = operation.send(None)
                    continue
                try:
                    response = self._send(step)
                except httpx2.TransportError as error:
                    step = operation.throw(error)
                else:
                    step = operation.send(response)
        except StopIteration as end:
            result: ResultT = end.value
            return result
        finally:
            operation.close()

    def lines(self, call: Call) -> Generator[str]:
        """Go through the lines of an answer as they come in.

        Raises
        ------
        ProblemError, UnexpectedResponse
            As by :func:`isomatch._exchange.checked`.
        httpx2.TransportError
            The connection failed.
        """
        response = self._send(call, stream=True)
        try:
            if not response.is_success:
                response.read()
            checked(response)
            yield from response.iter_lines()
        finally:
            response.close()

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def _send(self, call: Call, stream: bool = False) -> httpx2.Response:
        arguments = request_arguments(call, self._timeout)
        return self._http.send(
            self._http.build_request(**arguments),  # type: ignore[arg-type]
            stream=stream,
        )


def _headers(api_key: str | None) -> dict[str, str]:
    headers = {"user-agent": f"isomatch/{version('isomatch')}"}
    if api_key is not None:
        headers["authorization"] = f"Bearer {api_key}"
    return headers
