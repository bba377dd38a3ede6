"""Middleware round every request: its id and log line, unexpected errors, limits of its body."""

import asyncio
import contextlib
import re
import time
from collections.abc import Collection
from typing import Final
from uuid import uuid4

import structlog
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from broker.telemetry import logger
from service.http.problem_documents import response
from service.http.problems import (
    ApiProblem,
    BodyStalled,
    EncodedBody,
    InternalError,
    UploadTooLarge,
)

REQUEST_ID: Final = "X-Request-ID"
_ACCEPTED_ID: Final = re.compile(r"[A-Za-z0-9._-]{1,128}")
_QUIET: Final = ("/health/", "/metrics")

log = logger("isomatch.api")


class RequestContext:
    """Gives each request an id, logs it, and answers unexpected errors with a problem document.

    The id is the one the caller gave in ``X-Request-ID`` or a new one; it is in the answer and in
    all log lines, and goes with the jobs to the workers.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        given = Headers(scope=scope).get(REQUEST_ID, "")
        request_id = given if _ACCEPTED_ID.fullmatch(given) else uuid4().hex
        scope["state"] = {**scope.get("state", {}), "request_id": request_id}
        status = 0

        async def named(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)[REQUEST_ID] = request_id
            await send(message)

        start = time.perf_counter()
        with structlog.contextvars.bound_contextvars(request_id=request_id):
            try:
                await self._app(scope, receive, named)
            except Exception:
                log.exception("unexpected error", method=scope["method"], path=scope["path"])
                if status == 0:
                    problem = InternalError(
                        f"The service failed; its logs of request {request_id} have the cause."
                    )
                    await response(problem.problem(scope["path"]))(scope, receive, named)
            finally:
                quiet = scope["path"].startswith(_QUIET)
                (log.debug if quiet else log.info)(
                    "request",
                    method=scope["method"],
                    path=scope["path"],
                    status=status,
                    seconds=round(time.perf_counter() - start, 4),
                )


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

    FORM_OVERHEAD: Final = 64 * 1024
    """Bytes allowed for the boundaries, headers and other parts of an upload's form."""

    DRAIN_BYTES: Final = 1024**3
    """Most bytes of a refused body that are read before the answer is sent."""

    DRAIN_SECONDS: Final = 30.0
    """Longest time for which a refused body is read."""

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
        limit = self._upload_limit + self.FORM_OVERHEAD if uploads else self._limit
        shown = self._upload_limit if uploads else self._limit
        headers = Headers(scope=scope)
        length = headers.get("content-length", "")
        body = _Body(receive, limit, shown, self._patience)
        too_long = length.isdigit() and int(length) > limit
        problem = _encoded(headers) or (body.too_large if too_long else None)
        if problem is not None:
            if headers.get("expect", "").lower() != "100-continue":
                await body.drain(self.DRAIN_BYTES, self.DRAIN_SECONDS)
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
                    await body.drain(self.DRAIN_BYTES, self.DRAIN_SECONDS)
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

    async def drain(self, count: int, seconds: float) -> None:
        """Read on for a while: a client that is still sending would never read the answer."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(min(seconds, self._patience)):
                while not self._ended and count > 0:
                    message = await self._receive()
                    self._note(message)
                    count -= len(message.get("body", b""))

    def _note(self, message: Message) -> None:
        self._received += len(message.get("body", b""))
        self._ended = message["type"] != "http.request" or not message.get("more_body", False)
