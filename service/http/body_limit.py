"""Middleware that refuses bodies that are too long, too many, stalled or compressed."""

import asyncio
import contextlib
from collections.abc import Collection
from dataclasses import dataclass
from typing import Final

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.http.problem_documents import response
from service.http.problems import (
    ApiProblem,
    BodyStalled,
    EncodedBody,
    TooManyUploads,
    UploadTooLarge,
)
from service.http.upload_space import UploadSpace

FORM_OVERHEAD: Final = 64 * 1024
"""Bytes allowed for the boundaries, headers and other parts of an upload's form."""

LARGEST_UPLOADS: Final = 3
"""Uploads of the greatest size whose bodies are on their way at a time, or as many bytes of smaller
ones. The temporary directory of the API must hold them."""

LINGER_BYTES: Final = 16 * 1024**2
"""Most bytes of an unread body that are taken after the answer."""

LINGER_SECONDS: Final = 2.0
"""Longest time for which an unread body is taken after the answer."""

MOST_VALUES: Final = 100_000
"""Most commas and opening brackets of a body that is not an upload: 10,000 landmarks have 90,000.
Parsing takes time for each value, and while it lasts nobody else is answered."""

LARGE_BYTES: Final = 64 * 1024
"""Bytes from which on bodies that are not uploads are parsed one in a round of the event loop. Each
takes it for some 10 ms; others would wait for those of all clients."""

_LESS: Final = "send less in one request"

_SEPARATORS: Final = (b",", b"[", b"{")


class BodyRefused(HTTPException):
    """Raised where a body is read; FastAPI passes on only its own kind of exception there."""


class BodyLimit:
    """Refuses bodies that are over a limit, stalled or compressed, when they are to be read.

    A body over the limit is refused by its ``Content-Length``, or as soon as more was received. A
    request that is answered without its body, as those without a key or to a wrong address, is
    answered at once: of the body a little more is taken, as clients that are still sending may lose
    an answer on a closed connection, and then the connection is closed. The body of an upload is
    read when there is space for it among those of others.

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
        Seconds until a body of which nothing more is received is given up, or one for which there
        is no space.
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
        self._turn = asyncio.Lock()
        self._space = UploadSpace(LARGEST_UPLOADS * (upload_limit + FORM_OVERHEAD))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, and refuse it if its body cannot be taken."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        allowance = self._allowance(scope["path"])
        body = _Body(receive, allowance, Headers(scope=scope), self._patience)
        exchange = _Exchange(send, body)
        scope["state"] = {**scope.get("state", {}), "give_back_space": body.give_back_space}

        async def received() -> Message:
            if body.ended or body.allowance.values is None:
                return await body.receive()
            whole = await body.whole()
            if len(whole.get("body", b"")) > LARGE_BYTES:
                await self._turn.acquire()
                # It is parsed before the application waits for anything else.
                asyncio.get_running_loop().call_soon(self._turn.release)
            return whole

        async def replaced(message: Message) -> None:
            # The application's own answer to the broken-off body is dropped for the refusal.
            if body.refused is None:
                await exchange.send(message)

        try:
            await self._app(scope, received, replaced)
        finally:
            body.give_back_space()
            if body.refused is not None:
                headers = {**body.refused.headers, "Connection": "close"}
                answer = response(body.refused.problem(scope["path"]), headers)
                await answer(scope, body.receive, exchange.send)

    def _allowance(self, path: str) -> "_Allowance":
        if path in self._upload_paths:
            whole = self._upload_limit + FORM_OVERHEAD
            return _Allowance(whole, self._upload_limit, None, self._space)
        return _Allowance(self._limit, self._limit, MOST_VALUES, None)


@dataclass(frozen=True)
class _Allowance:
    """Most bytes of a body, as they are counted and as they are told; most values; its space."""

    bytes: int
    shown: int
    values: int | None
    space: UploadSpace | None


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
    def __init__(
        self, receive: Receive, allowance: _Allowance, headers: Headers, patience: float
    ) -> None:
        self.allowance = allowance
        self._receive = receive
        self._patience = patience
        self._received = 0
        self._values = 0
        length = headers.get("content-length", "")
        # A body that is sent in chunks does not tell its length.
        self._length = int(length) if length.isdigit() else allowance.bytes
        self._space_taken = 0
        self._unwanted = _encoded(headers) or self._too_long()
        # A client that waits to be told to go on sends nothing after a refusal.
        self._waits = headers.get("expect", "").lower() == "100-continue"
        self.ended = not _has_body(headers)
        self.refused: ApiProblem | None = None

    async def receive(self) -> Message:
        if self.ended:
            return await self._receive()
        if self._unwanted is not None:
            raise self._refuse(self._unwanted)
        if self.allowance.space is not None and not self._space_taken:
            await self._take_space(self.allowance.space)
        try:
            async with asyncio.timeout(self._patience):
                message = await self._receive()
        except TimeoutError:
            stalled = f"The body stalled for {self._patience:g} seconds; send it again."
            raise self._refuse(BodyStalled(stalled)) from None
        self._note(message)
        if self._received > self.allowance.bytes:
            raise self._refuse(self._too_large())
        if self.allowance.values is not None and self._values > self.allowance.values:
            raise self._refuse(
                UploadTooLarge(f"The body has more than {self.allowance.values} values; {_LESS}.")
            )
        return message

    def give_back_space(self) -> None:
        """Let others have the space of this body, which is not kept any more."""
        if self.allowance.space is not None:
            self.allowance.space.give_back(self._space_taken)
            self._space_taken = 0

    async def whole(self) -> Message:
        """Receive all of the body as one message, or the message that the client is gone."""
        parts = []
        while not self.ended:
            message = await self.receive()
            if message["type"] != "http.request":
                return message
            parts.append(message.get("body", b""))
        return {"type": "http.request", "body": b"".join(parts), "more_body": False}

    async def linger(self) -> None:
        """Take a little of what is still being sent."""
        most = LINGER_BYTES
        idle = self._waits and not self._received
        seconds = 0.0 if idle else min(LINGER_SECONDS, self._patience)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while not self.ended and most > 0:
                    message = await self._receive()
                    most -= len(message.get("body", b""))
                    self._note(message)

    async def _take_space(self, space: UploadSpace) -> None:
        try:
            async with asyncio.timeout(self._patience):
                await space.take(self._length)
        except TimeoutError:
            busy = "There is no space for the upload beside others on their way; send it later."
            raise self._refuse(TooManyUploads(busy)) from None
        self._space_taken = self._length

    def _refuse(self, problem: ApiProblem) -> BodyRefused:
        self.refused = problem
        return BodyRefused(problem.type.status)

    def _too_long(self) -> ApiProblem | None:
        return self._too_large() if self._length > self.allowance.bytes else None

    def _too_large(self) -> ApiProblem:
        if self.allowance.values is None:
            return UploadTooLarge.over(self.allowance.shown)
        return UploadTooLarge.over(self.allowance.shown, _LESS)

    def _note(self, message: Message) -> None:
        part = message.get("body", b"")
        self._received += len(part)
        self._values += sum(part.count(one) for one in _SEPARATORS)
        self.ended = message["type"] != "http.request" or not message.get("more_body", False)


class _Exchange:
    """Answers, and closes the connection if the body was not read to its end."""

    def __init__(self, send: Send, body: _Body) -> None:
        self._send = send
        self._body = body

    async def send(self, message: Message) -> None:
        if self._body.ended:
            await self._send(message)
        elif message["type"] == "http.response.start":
            MutableHeaders(scope=message)["Connection"] = "close"
            await self._send(message)
        elif message.get("more_body", False):
            await self._send(message)
        else:
            # The answer is sent, but not over: else the server would close the connection.
            await self._send({**message, "more_body": True})
            await self._body.linger()
            await self._send({"type": "http.response.body", "body": b""})
