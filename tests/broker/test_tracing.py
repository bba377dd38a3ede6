"""Traces: with the exporter in memory of the SDK, and off."""

import subprocess
import sys
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from threading import Thread

import pytest
import structlog
from opentelemetry.sdk.trace import ReadableSpan
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import StatusCode

from broker import tracing
from broker.contracts import BatchPayload, DissimilarityParameters, MatchParameters
from broker.contracts import DissimilaritiesPayload as Comparison
from broker.queue import new_job
from broker.queue.new_jobs import new_batch_match, new_time_slice
from broker.store import Store

CALLER = "00-000000000000000000000000000000e1-00000000000000aa-01"

BATCH = BatchPayload(source="a", targets=("b",), target_names=(None,), parameters=MatchParameters())
COMPARISON = Comparison(shapes=("a", "b"), labels=None, parameters=DissimilarityParameters())


@pytest.fixture
def memory() -> InMemorySpanExporter:
    return InMemorySpanExporter()


@pytest.fixture
def on(memory: InMemorySpanExporter) -> Iterator[None]:
    with tracing.exporting("test", memory):
        yield


def finished(memory: InMemorySpanExporter) -> dict[str, ReadableSpan]:
    """The spans by their names, once they are exported."""
    return {span.name: span for span in memory.get_finished_spans()}


def traceparent_of(span: ReadableSpan) -> str:
    ids = span.get_span_context()
    assert ids is not None
    return f"00-{ids.trace_id:032x}-{ids.span_id:016x}-01"


def test_off_imports_nothing_and_traces_nothing() -> None:
    script = (
        "import sys, service.app, worker.jobs, worker.process.process\n"
        "from broker import tracing\n"
        "with tracing.exporting('api'), tracing.span('a') as span:\n"
        "    tracing.prepare(); tracing.failed('b'); tracing.StageSpans().enter('c')\n"
        "    assert span is None and tracing.traceparent() is None\n"
        "needed = 'opentelemetry.sdk.trace.export', 'opentelemetry.exporter'\n"
        "print([name for name in sys.modules if name.startswith(needed)])"
    )
    assert subprocess.check_output([sys.executable, "-c", script], text=True) == "[]\n"


@pytest.mark.parametrize(
    ("variables", "on"),
    [
        ({}, False),
        ({"OTEL_EXPORTER_OTLP_ENDPOINT": "http://c:4318"}, True),
        ({"OTEL_EXPORTER_OTLP_TRACES_ENDPOINT": "http://c:4318/v1/traces"}, True),
        ({"OTEL_EXPORTER_OTLP_ENDPOINT": "http://c:4318", "OTEL_SDK_DISABLED": "true"}, False),
        ({"OTEL_EXPORTER_OTLP_ENDPOINT": "http://c:4318", "OTEL_TRACES_EXPORTER": "none"}, False),
        ({"OTEL_SERVICE_NAME": "a"}, False),
    ],
)
def test_the_standard_variables_are_the_switch(
    variables: dict[str, str], on: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert tracing.enabled() is on


def test_spans_are_children_and_bind_their_ids_to_the_log(memory: InMemorySpanExporter) -> None:
    with tracing.exporting("test", memory):
        with tracing.span("request", "SERVER", CALLER, name_of="value"):
            bound = structlog.contextvars.get_contextvars()
            given = tracing.traceparent()
            with tracing.span("within"):
                tracing.failed("reason")
        assert "trace_id" not in structlog.contextvars.get_contextvars()
    spans = finished(memory)
    request, within = spans["request"], spans["within"]
    assert request.parent is not None
    assert request.parent.span_id == 0xAA
    assert request.attributes == {"isomatch.name_of": "value"}
    assert given == traceparent_of(request) == f"00-{bound['trace_id']}-{bound['span_id']}-01"
    assert bound["trace_id"] == CALLER[3:35]
    assert within.parent == request.get_span_context()
    assert within.status.status_code is StatusCode.ERROR
    assert request.resource.attributes["service.name"] == "isomatch-test"


@pytest.mark.parametrize("parent", ["", "nonsense", "00-" + "0" * 32 + "-" + "0" * 16 + "-01"])
def test_a_caller_that_names_no_trace_begins_one(memory: InMemorySpanExporter, parent: str) -> None:
    with tracing.exporting("test", memory), tracing.span("request", "SERVER", parent):
        pass
    assert finished(memory)["request"].parent is None


def test_stages_follow_one_another_also_from_other_threads(memory: InMemorySpanExporter) -> None:
    with tracing.exporting("test", memory), tracing.span("job"):
        stages = tracing.StageSpans()
        stages.enter("first")
        thread = Thread(target=stages.enter, args=("second",))
        thread.start()
        thread.join()
        stages.leave()
    spans = finished(memory)
    job, first, second = spans["job"], spans["first"], spans["second"]
    assert first.parent == second.parent == job.get_span_context()
    assert first.end_time is not None
    assert second.start_time is not None
    assert first.end_time <= second.start_time


def test_an_attempt_links_to_a_lost_one(memory: InMemorySpanExporter) -> None:
    end = datetime.now(UTC)
    with tracing.exporting("test", memory):
        lost = tracing.past_span("lost", CALLER, end - timedelta(seconds=3), end, "signal 9")
        with tracing.span("again", parent=CALLER, linked=lost):
            pass
    spans = finished(memory)
    assert lost == traceparent_of(spans["lost"])
    assert spans["lost"].status.status_code is StatusCode.ERROR
    (link,) = spans["again"].links
    ids = spans["lost"].get_span_context()
    assert ids is not None
    assert (link.context.trace_id, link.context.span_id) == (ids.trace_id, ids.span_id)
    start_time, end_time = spans["lost"].start_time, spans["lost"].end_time
    assert start_time is not None
    assert end_time is not None
    assert (end_time - start_time) / 1e9 == pytest.approx(3.0, abs=1e-3)


@pytest.mark.usefixtures("on")
def test_jobs_and_their_parts_carry_the_trace_of_the_request(store: Store) -> None:
    with tracing.span("request"):
        given = tracing.traceparent()
        batch, comparison = new_job(BATCH), new_job(COMPARISON)
    assert given is not None
    parts = new_batch_match(batch, 0), new_time_slice(comparison, 1)
    assert {job.traceparent for job in (batch, comparison, *parts)} == {given}
    with store.client.pipeline() as pipe:
        store.jobs.create(batch, pipe)
        pipe.execute()
    kept = store.jobs.get(batch.id)
    assert kept is not None
    assert kept.traceparent == given


def test_jobs_of_no_trace_are_stored_as_before() -> None:
    assert new_job(BATCH).traceparent is None
