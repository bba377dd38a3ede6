"""Transport of the asynchronous client: runs operations with asynchronous I/O."""

from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import AsyncExitStack, aclosing, closing
from typing import Final, NoReturn, TypeVar

import anyio
import httpx2

from isomatch._errors import ClientClosed
from isomatch._http.answers import undecodable
from isomatch._http.blocking_transport import advance
from isomatch._http.httpx_arguments import CLOSED, CONNECTED, client_arguments, request_arguments
from isomatch._http.operation import Call, Item, Listen, NextLine, Operation, Pause, Stream
from isomatch._http.retries import with_retries

ResultT = TypeVar("ResultT")

WITHDRAWAL: Final = 30.0
"""Seconds for which a task that was cancelled may withdraw what it has started."""


class AsyncTransport:
    """Runs operations against one service, in the calling task.

    Parameters as of :class:`isomatch._http.blocking_transport.BlockingTransport`. A task that is
    cancelled ends the operation and closes its connection.
    """

    def __init__(
        self,
        base_url: str,
        timeout: float | None,
        retries: int,
        transport: httpx2.AsyncBaseTransport | None,
        api_key: str | None,
    ) -> None:
        self._timeout = timeout
        self.retries = retries
        self._http = httpx2.AsyncClient(transport=transport, **client_arguments(base_url, api_key))

    def __reduce__(self) -> NoReturn:
        raise TypeError(CONNECTED)

    async def run(self, operation: Operation[ResultT]) -> ResultT:
        """Run an operation and return its value."""
        repeated, outcome = with_retries(operation, self.retries), None
        try:
            while True:
                outcome = await self._outcome(advance(repeated, outcome))
        except StopIteration as end:
            result: ResultT = end.value
            return result
        finally:
            repeated.close()

    async def run_shielded(self, operation: Operation[ResultT]) -> ResultT | None:
        """Run an operation also in a task that is cancelled, for at most `WITHDRAWAL` seconds."""
        with anyio.move_on_after(WITHDRAWAL, shield=True):
            return await self.run(operation)
        return None

    async def stream(self, operation: Stream[ResultT]) -> AsyncGenerator[ResultT]:
        """Run a stream and yield its items as they arrive."""
        lines: AsyncIterator[str] | None = None
        outcome: object = None
        with closing(operation):
            async with AsyncExitStack() as listening:
                while True:
                    try:
                        step = advance(operation, outcome)
                    except StopIteration:
                        return
                    if isinstance(step, Item):
                        yield step.value
                        outcome = None
                    elif isinstance(step, Listen):
                        await listening.aclose()
                        outcome = await self._outcome(step.call, stream=True)
                        if isinstance(outcome, httpx2.Response):
                            await listening.enter_async_context(aclosing(outcome))
                            lines = outcome.aiter_lines()
                    elif isinstance(step, NextLine):
                        assert lines is not None
                        outcome = await _line(lines)
                    else:
                        outcome = await self._outcome(step)

    async def close(self) -> None:
        """Close the connections."""
        await self._http.aclose()

    async def _outcome(
        self, step: Call | Pause, stream: bool = False
    ) -> httpx2.Response | httpx2.TransportError | None:
        if isinstance(step, Pause):
            await anyio.sleep(step.seconds)
            return None
        if self._http.is_closed:
            raise ClientClosed(CLOSED)
        request = self._http.build_request(**request_arguments(step, self._timeout))
        try:
            response = await self._http.send(request, stream=stream)
            if stream and not response.is_success:
                await response.aread()
        except httpx2.TransportError as error:
            return error
        except httpx2.DecodingError as error:
            raise undecodable(error) from error
        return response


async def _line(lines: AsyncIterator[str]) -> str | httpx2.TransportError | None:
    try:
        return await anext(lines, None)
    except httpx2.TransportError as error:
        return error
    except httpx2.DecodingError as error:
        raise undecodable(error) from error
