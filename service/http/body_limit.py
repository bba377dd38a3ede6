"""Middleware that refuses bodies that are too long, stalled or compressed."""

import asyncio
import contextlib
from collections.abc import Collection
from typing import Final

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.http.problem_documents import response
from service.http.problems import ApiProblem, BodyStalled, EncodedBody, UploadTooLarge

FORM_OVERHEAD: Final = 64 * 1024
"""Bytes allowed for the boundaries, headers and other parts of an upload's form."""

DRAIN_BYTES: Final = 1024**3
"""Most bytes of a refused body that are read before the answer is sent."""

DRAIN_SECONDS: Final = 30.0
"""Longest time for which a refused body is read."""


async def drain(receive: Receive, seconds: float = DRAIN_SECONDS) -> None:
    """Drain a refused body: a client that is still sending would never read the response."""
    most, more = DRAIN_BYTES, True
    with contextlib.suppress(TimeoutError, BodyRefused):
        async with asyncio.timeout(seconds):
            while more and most > 0:
                message = await receive()
                most -= len(message.get("body", b""))
                more = message["type"] == "http.request" and message.get("more_body", False)


class BodyRefused(HTTPException):
    """Raised where a body is read; FastAPI passes on only its own kind of exception there."""


class BodyLimit:
    """Refuses bodies that are over a limit, stalled or compressed.

    A body over the limit is refused by its ``Content-Length``, or as soon as more was received.

    Parameters
    ----------
    app
        The application.
    limit
        Most bytes of a body.
    upload_limit
        Most bytes of an upload; its body may be longer by the multipart form around it.
    upload_paths
        Addresses that uploads are sent to.
    patience
        Seconds until a body of which nothing more is received is given up.
    """

    def __init__(
        self,
        app: ASGIApp,
        limit: int,
        upload_limit: int,
        upload_paths: Collection[str],
        patience: float,
    ) -> None:
        self._app = app
        self._limit = limit
        self._upload_limit = upload_limit
        self._upload_paths = upload_paths
        self._patience = patience

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, and refuse it if its body cannot be taken."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        uploads = scope["path"] in self._upload_paths
        limit = self._upload_limit + FORM_OVERHEAD if uploads else self._limit
        shown = self._upload_limit if uploads else self._limit
        headers = Headers(scope=scope)
        length = headers.get("content-length", "")
        body = _Body(receive, limit, shown, self._patience)
        too_long = length.isdigit() and int(length) > limit
        problem = _encoded(headers) or (body.too_large if too_long else None)
        if problem is not None:
            if headers.get("expect", "").lower() != "100-continue":
                await body.drain()
            await self._refuse(problem, scope, receive, send)
            return

        async def replaced(message: Message) -> None:
            # The application's own answer to the broken-off body is dropped for the refusal.
            if body.refused is None:
                await send(message)

        try:
            await self._app(scope, body.receive, replaced)
        finally:
            if body.refused is not None:
                if body.refused is body.too_large:
                    await body.drain()
                await self._refuse(body.refused, scope, receive, send)

    async def _refuse(
        self, problem: ApiProblem, scope: Scope, receive: Receive, send: Send
    ) -> None:
        answer = response(problem.problem(scope["path"]), {"Connection": "close"})
        await answer(scope, receive, send)


def _encoded(headers: Headers) -> ApiProblem | None:
    encoding = headers.get("content-encoding", "").strip()
    if encoding.lower() in ("", "identity") or not _has_body(headers):
        return None
    return EncodedBody(
        f"Content-Encoding {encoding[:40]!r} is not supported in requests; send the body as it is."
    )


def _has_body(headers: Headers) -> bool:
    return "transfer-encoding" in headers or headers.get("content-length", "0").strip("0") != ""


class _Body:
    def __init__(self, receive: Receive, limit: int, shown: int, patience: float) -> None:
        self._receive = receive
        self._limit = limit
        self._patience = patience
        self._received = 0
        self._ended = False
        self.too_large = UploadTooLarge(f"The limit is {shown} bytes.")
        self.refused: ApiProblem | None = None

    async def receive(self) -> Message:
        if self._ended:
            return await self._receive()
        try:
            async with asyncio.timeout(self._patience):
                message = await self._receive()
        except TimeoutError:
            self.refused = BodyStalled(
                f"The body stalled for {self._patience:g} seconds; send it again."
            )
            raise BodyRefused(self.refused.status) from None
        self._note(message)
        if self._received > self._limit:
            self.refused = self.too_large
            raise BodyRefused(self.refused.status)
        return message

    async def drain(self) -> None:
        if not self._ended:
            await drain(self._receive, min(DRAIN_SECONDS, self._patience))

    def _note(self, message: Message) -> None:
        self._received += len(message.get("body", b""))
        self._ended = message["type"] != "http.request" or not message.get("more_body", False)
