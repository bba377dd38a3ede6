"""A collector of traces: takes OTLP over HTTP, as any other would."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest


@dataclass(frozen=True)
class Exported:
    """A span as it was exported."""

    service: str
    name: str
    trace: str
    id: str
    parent: str
    links: tuple[str, ...]
    seconds: tuple[float, float]
    failed: bool
    attributes: dict[str, str]


@dataclass
class Collector:
    """What was exported so far."""

    url: str = ""
    spans: list[Exported] = field(default_factory=list)

    def of(self, trace: str) -> list[Exported]:
        """Return the spans of a trace, in the order of their beginnings."""
        return sorted((span for span in self.spans if span.trace == trace), key=_start)


def _start(span: Exported) -> float:
    return span.seconds[0]


def _spans(body: bytes) -> Iterator[Exported]:
    request = ExportTraceServiceRequest.FromString(body)
    for resource in request.resource_spans:
        named = {pair.key: pair.value.string_value for pair in resource.resource.attributes}
        for scope in resource.scope_spans:
            for span in scope.spans:
                yield Exported(
                    service=named["service.name"],
                    name=span.name,
                    trace=span.trace_id.hex(),
                    id=span.span_id.hex(),
                    parent=span.parent_span_id.hex(),
                    links=tuple(link.span_id.hex() for link in span.links),
                    seconds=(span.start_time_unix_nano / 1e9, span.end_time_unix_nano / 1e9),
                    failed=span.status.code == 2,
                    attributes={pair.key: pair.value.string_value for pair in span.attributes},
                )


@contextmanager
def collecting() -> Iterator[Collector]:
    """Run a collector on a free port of the loopback interface."""
    collector = Collector()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            collector.spans.extend(_spans(body))
            self.send_response(200)
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    collector.url = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield collector
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
