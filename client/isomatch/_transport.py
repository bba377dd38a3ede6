"""Runs operations over blocking I/O; the only module that knows how this client waits."""

import json
import time
from importlib.metadata import version
from typing import TypeVar

import httpx2

from isomatch._exchange import Call, Operation, Pause

ResultT = TypeVar("ResultT")

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})


def request_arguments(call: Call, timeout: float | None) -> dict[str, object]:
    """Return a call as the keyword arguments of ``build_request``, sync and async alike."""
    arguments: dict[str, object] = {
        "method": call.method,
        "url": call.path,
        "params": {key: value for key, value in call.query.items() if value is not None},
        "timeout": None if timeout is None else timeout + call.patience,
    }
    if call.body is not None:
        arguments["content"] = json.dumps(call.body, allow_nan=False).encode()
        arguments["headers"] = {"content-type": "application/json"}
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
    """

    def __init__(
        self, base_url: str, timeout: float | None, transport: httpx2.BaseTransport | None
    ) -> None:
        self._timeout = timeout
        self._http = httpx2.Client(
            base_url=base_url,
            transport=transport,
            headers={"user-agent": f"isomatch/{version('isomatch')}"},
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

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def _send(self, call: Call) -> httpx2.Response:
        return self._http.send(
            self._http.build_request(**request_arguments(call, self._timeout))  # type: ignore[arg-type]
        )
