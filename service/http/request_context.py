"""Middleware that gives each request an id and a log line, and answers unexpected errors."""

import asyncio
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final
from uuid import uuid4

import structlog
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from broker.telemetry import logger
from broker.tracing import failed, span
from service.http.problem_documents import response
from service.http.problems import InternalError, NotReady

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
        quiet = scope["path"].startswith(_QUIET)
        with structlog.contextvars.bound_contextvars(request_id=request_id), _traced(scope, quiet):
            try:
                await self._app(scope, receive, named)
            except asyncio.CancelledError:
                # The server stops, and the request has not ended in the time that it had.
                if status != 0:
                    raise
                stopping = NotReady("The service is stopping; send the request again.")
                headers = {"Retry-After": "5", "Connection": "close"}
                await response(stopping.problem(scope["path"]), headers)(scope, receive, named)
            except Exception:
                log.exception("unexpected error", method=scope["method"], path=scope["path"])
                if status == 0:
                    problem = InternalError(
                        f"The service failed; its logs of request {request_id} have the cause."
                    )
                    await response(problem.problem(scope["path"]))(scope, receive, named)
            finally:
                scope["state"]["status"] = status
                (log.debug if quiet else log.info)(
                    "request",
                    method=scope["method"],
                    path=scope["path"],
                    status=status,
                    seconds=round(time.perf_counter() - start, 4),
                )


@contextmanager
def _traced(scope: Scope, quiet: bool) -> Iterator[None]:
    """Trace a request as a part of the trace that the caller names, if it names one."""
    if quiet:
        yield
        return
    parent = Headers(scope=scope).get("traceparent", "")
    with span(scope["method"], kind="SERVER", parent=parent) as traced:
        if traced is None:
            yield
            return
        state = scope["state"]
        state["trace_id"] = format(traced.get_span_context().trace_id, "032x")
        try:
            yield
        finally:
            route = getattr(scope.get("route"), "path", None)
            traced.update_name(scope["method"] if route is None else f"{scope['method']} {route}")
            traced.set_attributes(
                {
                    "http.request.method": scope["method"],
                    "http.response.status_code": state.get("status", 0),
                    "http.route": route or "",
                    "url.path": scope["path"],
                    "isomatch.request_id": state["request_id"],
                }
            )
            if state.get("status", 0) >= 500:
                failed(str(state["status"]))
