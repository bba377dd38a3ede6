"""Traces of OpenTelemetry: off, unless the environment names a collector of OTLP over HTTP.

The standard variables are the settings: ``OTEL_EXPORTER_OTLP_ENDPOINT``, ``OTEL_SERVICE_NAME``,
``OTEL_TRACES_SAMPLER``, ``OTEL_SDK_DISABLED`` and so on. While traces are off no exporter
is imported, and every function here returns at once.

The trace of a request goes with its jobs as ``traceparent`` (W3C Trace Context) in their records.
Log lines within a span have its ``trace_id`` and ``span_id``.
"""

import os
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime
from typing import TYPE_CHECKING, Final

import structlog

from broker.circuit_breaker import CircuitBreaker
from broker.telemetry import logger

if TYPE_CHECKING:
    from opentelemetry.context import Context
    from opentelemetry.sdk.trace import ReadableSpan, TracerProvider
    from opentelemetry.sdk.trace.export import SpanExporter, SpanExportResult
    from opentelemetry.trace import Link, Span, Tracer

Value = str | int | float | bool

ENDPOINTS: Final = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")
"""Variables that name a collector, and so switch traces on."""

LAST_EXPORT: Final = 1.0
"""Seconds that the end of a process, and so of each job's, waits for its spans to be exported."""

AWAY: Final = 60.0
"""Seconds for which nothing is sent to a collector that did not take spans."""

_COLLECTOR: Final = CircuitBreaker()

log = logger("isomatch.tracing")

_tracer: "Tracer | None" = None


def enabled() -> bool:
    """Return whether the environment asks for traces."""
    environment = os.environ
    return (
        any(environment.get(name) for name in ENDPOINTS)
        and environment.get("OTEL_SDK_DISABLED", "").lower() != "true"
        and environment.get("OTEL_TRACES_EXPORTER", "otlp") == "otlp"
    )


def prepare() -> None:
    """Import what spans need, if traces are on, in the process that forks those of the jobs."""
    if enabled():
        _otlp_exporter()


@contextmanager
def exporting(process: str, exporter: "SpanExporter | None" = None) -> Iterator[None]:
    """Export the spans of this process while a block of code runs, if traces are on.

    No more than 2048 spans wait (``OTEL_BSP_MAX_QUEUE_SIZE``), and a thread sends them. At the end
    of the block the last ones are awaited for :data:`LAST_EXPORT` seconds.

    Parameters
    ----------
    process
        Kind of the process: ``"api"`` or ``"worker"``.
    exporter
        Exporter instead of that of the environment.
    """
    global _tracer
    if _tracer is not None or not (exporter or enabled()):
        yield
        return
    provider = _provider(process, exporter or _SparingExporter(_otlp_exporter()))
    _tracer = provider.get_tracer("isomatch")
    try:
        yield
    finally:
        _tracer = None
        _shut_down(provider)


@contextmanager
def span(
    name: str,
    kind: str = "INTERNAL",
    parent: str | None = None,
    linked: str | None = None,
    **attributes: Value,
) -> Iterator["Span | None"]:
    """Trace a block of code; None while traces are off.

    Parameters
    ----------
    name
        Name of the span; its log lines have its ids.
    kind
        ``"INTERNAL"``, ``"SERVER"`` or ``"CONSUMER"``.
    parent
        ``traceparent`` of the parent; by default the present span.
    linked
        ``traceparent`` of an earlier span that this one continues.
    attributes
        Of the span, each named ``isomatch.NAME``.
    """
    tracer = _tracer
    if tracer is None:
        yield None
        return
    from opentelemetry.trace import SpanKind, format_span_id, format_trace_id

    with tracer.start_as_current_span(
        name,
        context=_context(parent),
        kind=SpanKind[kind],
        links=_links(linked),
        attributes=_attributes(attributes),
    ) as started:
        ids = started.get_span_context()
        with structlog.contextvars.bound_contextvars(
            trace_id=format_trace_id(ids.trace_id), span_id=format_span_id(ids.span_id)
        ):
            yield started


def past_span(
    name: str,
    parent: str | None,
    start: datetime,
    end: datetime,
    error: str | None = None,
    **attributes: Value,
) -> str | None:
    """Record a span that has ended already, and return its ``traceparent``; None while off."""
    if _tracer is None:
        return None
    from opentelemetry import trace

    past = _tracer.start_span(
        name,
        context=_context(parent),
        start_time=_nanoseconds(start),
        attributes=_attributes(attributes),
    )
    if error is not None:
        past.set_status(trace.StatusCode.ERROR, error)
    # The clocks of two machines differ.
    past.end(max(_nanoseconds(start), _nanoseconds(end)))
    return _traceparent(trace.set_span_in_context(past))


def traceparent() -> str | None:
    """Return the present span as W3C Trace Context; None without one."""
    return None if _tracer is None else _traceparent(None)


def failed(reason: str) -> None:
    """Give the present span the status of an error."""
    if _tracer is not None:
        from opentelemetry import trace

        trace.get_current_span().set_status(trace.StatusCode.ERROR, reason)


class StageSpans:
    """Spans of stages that follow one another, children of the span that is present now."""

    def __init__(self) -> None:
        self._open: Span | None = None
        self._context: Context | None = None
        if _tracer is not None:
            from opentelemetry.context import get_current

            # Progress may be reported by another thread.
            self._context = get_current()

    def enter(self, stage: str) -> None:
        """End the stage before, and begin one."""
        self.leave()
        if _tracer is not None:
            self._open = _tracer.start_span(stage, context=self._context)

    def leave(self) -> None:
        """End the last stage."""
        if self._open is not None:
            self._open.end()
            self._open = None


def _provider(process: str, exporter: "SpanExporter | _SparingExporter") -> "TracerProvider":
    from opentelemetry.sdk.resources import Resource
    from opentelemetry.sdk.trace import TracerProvider
    from opentelemetry.sdk.trace.export import BatchSpanProcessor

    resource = Resource.create()
    # The name of the environment takes precedence.
    if str(resource.attributes["service.name"]).startswith("unknown_service"):
        resource = resource.merge(Resource({"service.name": f"isomatch-{process}"}))
    provider = TracerProvider(resource=resource, shutdown_on_exit=False)
    # Ours has what the processor calls, but does not derive from its class.
    provider.add_span_processor(BatchSpanProcessor(exporter))  # type: ignore[arg-type]
    return provider


def _otlp_exporter() -> "SpanExporter":
    from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
    from opentelemetry.sdk.trace import TracerProvider  # noqa: F401 - imported beforehand
    from opentelemetry.trace.propagation import tracecontext  # noqa: F401 - imported beforehand

    return OTLPSpanExporter()


def _shut_down(provider: "TracerProvider") -> None:
    """Export what is left, but leave if the collector does not take it in time."""
    ending = threading.Thread(target=provider.shutdown, daemon=True)
    ending.start()
    ending.join(LAST_EXPORT)
    if ending.is_alive():
        _spare_collector()


def _spare_collector() -> None:
    _COLLECTOR.open(AWAY)
    log.warning("the collector of traces takes no spans; they are dropped", seconds=AWAY)


class _SparingExporter:
    """An exporter that leaves a collector alone for a while that did not take spans."""

    def __init__(self, exporter: "SpanExporter") -> None:
        self._exporter = exporter

    def export(self, spans: Sequence["ReadableSpan"]) -> "SpanExportResult":
        """Export spans, or drop them."""
        from opentelemetry.sdk.trace.export import SpanExportResult

        if _COLLECTOR.is_open():
            return SpanExportResult.FAILURE
        result = self._exporter.export(spans)
        if result is SpanExportResult.SUCCESS:
            _COLLECTOR.close()
        else:
            _spare_collector()
        return result

    def shutdown(self) -> None:
        """Close the connection."""
        self._exporter.shutdown()

    def force_flush(self, timeout_millis: int = 30000) -> bool:
        """Return at once: nothing is kept here."""
        return True


def _context(parent: str | None) -> "Context | None":
    if parent is None:
        return None
    from opentelemetry.context import Context
    from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator

    return TraceContextTextMapPropagator().extract({"traceparent": parent}, Context())


def _traceparent(context: "Context | None") -> str | None:
    from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator

    carrier: dict[str, str] = {}
    TraceContextTextMapPropagator().inject(carrier, context)
    return carrier.get("traceparent")


def _links(linked: str | None) -> "list[Link]":
    if linked is None:
        return []
    from opentelemetry import trace

    earlier = trace.get_current_span(_context(linked)).get_span_context()
    return [trace.Link(earlier)] if earlier.is_valid else []


def _attributes(given: dict[str, Value]) -> dict[str, Value]:
    return {f"isomatch.{name}": value for name, value in given.items()}


def _nanoseconds(moment: datetime) -> int:
    return int(moment.timestamp() * 1e9)
