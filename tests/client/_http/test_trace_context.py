"""The trace of a program that uses OpenTelemetry goes with its requests."""

import subprocess
import sys

from isomatch._http.httpx_arguments import request_arguments
from isomatch._http.operation import Call
from opentelemetry import propagate
from opentelemetry.sdk.trace import TracerProvider


def test_requests_name_the_present_span() -> None:
    assert propagate.inject is not None
    tracer = TracerProvider(shutdown_on_exit=False).get_tracer("test")
    call = Call("POST", "/v1/matches", body={}, headers={"idempotency-key": "k"})
    with tracer.start_as_current_span("caller") as span:
        headers = request_arguments(call, 1.0)["headers"]
    ids = span.get_span_context()
    given = headers.pop("traceparent")
    assert given == f"00-{ids.trace_id:032x}-{ids.span_id:016x}-{ids.trace_flags:02x}"
    assert headers == {"idempotency-key": "k", "content-type": "application/json"}
    assert "traceparent" not in request_arguments(call, 1.0)["headers"]


def test_other_programs_import_nothing_for_it() -> None:
    script = "import sys, isomatch; print('opentelemetry' in sys.modules)"
    assert subprocess.check_output([sys.executable, "-c", script], text=True) == "False\n"
