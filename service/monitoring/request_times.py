"""Durations of requests by method, route and status, for Prometheus."""

import time
from typing import Final

from prometheus_client import CollectorRegistry, Gauge, Histogram
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_BOUNDS: Final = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 60.0)
"""Upper bounds of the buckets in seconds, about half a decade apart."""

_METHODS: Final = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


class RequestTimes:
    """The measurements of the requests of one process.

    Parameters
    ----------
    registry
        Registry that they are added to.
    """

    def __init__(self, registry: CollectorRegistry) -> None:
        self.seconds = Histogram(
            "isomatch_http_request_seconds",
            "Seconds until the answer began; calls that wait for a job take as long as they wait.",
            ("method", "route", "status"),
            buckets=_BOUNDS,
            registry=registry,
        )
        self.open = Gauge(
            "isomatch_http_requests_open",
            "Requests that are being answered, streams of events among them.",
            registry=registry,
        )


class MeasureRequests:
    """ASGI middleware that measures each request.

    Parameters
    ----------
    app
        The application.
    times
        The measurements.
    """

    def __init__(self, app: ASGIApp, times: RequestTimes) -> None:
        self._app = app
        self._times = times

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        start = time.perf_counter()

        async def noted(message: Message) -> None:
            if message["type"] == "http.response.start":
                method = scope["method"] if scope["method"] in _METHODS else "other"
                labels = method, _route(scope), str(message["status"])
                trace = scope.get("state", {}).get("trace_id")
                self._times.seconds.labels(*labels).observe(
                    time.perf_counter() - start, None if trace is None else {"trace_id": trace}
                )
            await send(message)

        with self._times.open.track_inprogress():
            await self._app(scope, receive, noted)


def _route(scope: Scope) -> str:
    # Unknown addresses share one label, or clients could make any number of them.
    return str(getattr(scope.get("route"), "path", "none"))
