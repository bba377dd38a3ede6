"""Transport of the blocking client: runs operations with blocking I/O."""

import time
from collections.abc import Generator, Iterator
from contextlib import ExitStack, closing
from typing import Any, NoReturn, TypeVar

import httpx2

from isomatch._errors import ClientClosed
from isomatch._http.answers import undecodable
from isomatch._http.httpx_arguments import CLOSED, CONNECTED, client_arguments, request_arguments
from isomatch._http.operation import Call, Item, Listen, NextLine, Operation, Pause, Stream
from isomatch._http.retries import with_retries

ResultT = TypeVar("ResultT")


def advance(operation: Generator[Any, Any, Any], outcome: object) -> Any:
    """Send an operation the outcome of its last step, and return its next step."""
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
        Greatest number of repetitions of a request.
    transport
        httpx2 transport to use instead of the network.
    api_key
        Key that is sent with every request; None for none.
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

    def __reduce__(self) -> NoReturn:
        raise TypeError(CONNECTED)

    def run(self, operation: Operation[ResultT]) -> ResultT:
        """Run an operation and return its value."""
        repeated, outcome = with_retries(operation, self.retries), None
        try:
            while True:
                outcome = self._outcome(advance(repeated, outcome))
        except StopIteration as end:
            result: ResultT = end.value
            return result
        finally:
            repeated.close()

    def run_shielded(self, operation: Operation[ResultT]) -> ResultT:
        """Run an operation; that of :class:`AsyncTransport` does so in a cancelled task, too."""
        return self.run(operation)

    def stream(self, operation: Stream[ResultT]) -> Generator[ResultT]:
        """Run a stream and yield its items as they arrive."""
        lines: Iterator[str] = iter(())
        outcome: object = None
        with closing(operation), ExitStack() as listening:
            while True:
                try:
                    step = advance(operation, outcome)
                except StopIteration:
                    return
                if isinstance(step, Item):
                    yield step.value
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

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def _outcome(
        self, step: Call | Pause, stream: bool = False
    ) -> httpx2.Response | httpx2.TransportError | None:
        if isinstance(step, Pause):
            time.sleep(step.seconds)
            return None
        if self._http.is_closed:
            raise ClientClosed(CLOSED)
        request = self._http.build_request(**request_arguments(step, self._timeout))
        try:
            response = self._http.send(request, stream=stream)
            if stream and not response.is_success:
                response.read()
        except httpx2.TransportError as error:
            return error
        except httpx2.DecodingError as error:
            raise undecodable(error) from error
        return response


def _line(lines: Iterator[str]) -> str | httpx2.TransportError | None:
    try:
        return next(lines, None)
    except httpx2.TransportError as error:
        return error
    except httpx2.DecodingError as error:
        raise undecodable(error) from error
