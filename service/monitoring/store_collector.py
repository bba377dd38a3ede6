"""Metrics of jobs, workers and caches, read from the store when Prometheus scrapes."""

from collections.abc import Iterator
from itertools import accumulate
from typing import Final

from prometheus_client.core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    Metric,
)
from prometheus_client.registry import Collector
from redis.exceptions import RedisError

from broker.contracts import JobKind, JobState, ProblemType
from broker.queue import JobQueue, depths, longest_wait, worker_states
from broker.store import BUCKET_BOUNDS, CounterValues, Histogram, Keys, Store, memory
from broker.telemetry import logger

_ALERTED: Final = (ProblemType.WORKER_LOST, ProblemType.INTERNAL_ERROR, ProblemType.OUT_OF_MEMORY)
"""Problems whose counters begin with 0: Prometheus sees no increase in one that begins with 1."""

log = logger("isomatch.api")


class StoreCollector(Collector):
    """Collector of the metrics that are kept in the store.

    Parameters
    ----------
    queue
        The queue and, through it, the store.
    """

    def __init__(self, queue: JobQueue) -> None:
        self._queue = queue

    def describe(self) -> Iterator[Metric]:
        """Describe nothing: the labels are only known when the store is read."""
        return iter(())

    def collect(self) -> Iterator[Metric]:
        """Read all metrics; if the store cannot be reached, report only that."""
        metrics: list[Metric] = []
        try:
            metrics += _present(self._queue)
            metrics += _counted(self._queue.store.counters.read())
            metrics += _spectra(self._queue.store)
            metrics += _memory(self._queue.store)
        except RedisError as error:
            log.warning("metrics of the store cannot be read", error=str(error))
            metrics = []
        there = float(bool(metrics))
        yield GaugeMetricFamily("isomatch_store_up", "Whether the store answers.", value=there)
        yield from metrics


def _present(queue: JobQueue) -> Iterator[Metric]:
    waiting = GaugeMetricFamily("isomatch_queue_jobs", "Jobs that wait.", labels=["queue"])
    running = GaugeMetricFamily("isomatch_running_jobs", "Jobs that run.", labels=["queue"])
    for name, (waits, runs) in depths(queue.rq.all()).items():
        waiting.add_metric([name], waits)
        running.add_metric([name], runs)
    age = GaugeMetricFamily(
        "isomatch_queue_age_seconds",
        "Seconds for which the oldest of the next 200 jobs has waited.",
        value=longest_wait(queue.rq.all()),
    )
    states = worker_states(queue.store.client)
    workers = GaugeMetricFamily("isomatch_workers", "Workers alive.", labels=["state"])
    for state in sorted({"idle", "busy", *states}):
        workers.add_metric([state], states.count(state))
    kept = GaugeMetricFamily(
        "isomatch_jobs", "Jobs that were asked for and are remembered.", labels=["state"]
    )
    listed = _listed(queue.store)
    for state in JobState:
        kept.add_metric([state.value], listed[state])
    shapes = GaugeMetricFamily("isomatch_shapes", "Shapes that are kept.", value=listed["shapes"])
    prototypes = GaugeMetricFamily(
        "isomatch_prototypes", "Prototypes that are kept.", value=listed["prototypes"]
    )
    webhooks = GaugeMetricFamily(
        "isomatch_webhooks_pending",
        "Jobs that have ended and whose webhook is still to be delivered.",
        value=listed["webhooks"],
    )
    yield from (waiting, running, age, workers, kept, shapes, prototypes, webhooks)


def _listed(store: Store) -> dict[str, int]:
    """Return the numbers of jobs by state, and of shapes, prototypes and webhooks, of all tenants.

    In one round trip: a scrape has no time for one per tenant.
    """
    keys = [Keys(tenant) for tenant in store.tenants()]
    with store.client.pipeline(transaction=False) as pipe:
        for one in keys:
            for state in JobState:
                pipe.zcard(one.jobs_in(state))
            for listing in (one.shapes, one.prototypes, one.webhooks):
                pipe.zcard(listing)
        counts = pipe.execute()
    names = [*JobState, "shapes", "prototypes", "webhooks"]
    return {name: sum(counts[place :: len(names)]) for place, name in enumerate(names)}


def _counted(counts: CounterValues) -> Iterator[Metric]:
    submitted = CounterMetricFamily(
        "isomatch_jobs_submitted", "Jobs that were queued.", labels=["kind"]
    )
    for kind, count in sorted(counts.submitted.items()):
        submitted.add_metric([kind], count)
    ended = CounterMetricFamily(
        "isomatch_jobs_ended", "Jobs that have ended.", labels=["kind", "state"]
    )
    for labels, count in sorted(counts.ended.items()):
        ended.add_metric(labels, count)
    failures = CounterMetricFamily(
        "isomatch_job_failures", "Jobs that have failed, and why.", labels=["kind", "problem"]
    )
    first = {(kind.value, problem.slug): 0 for kind in JobKind for problem in _ALERTED}
    for labels, count in sorted((first | counts.failures).items()):
        failures.add_metric(labels, count)
    times = HistogramMetricFamily(
        "isomatch_job_seconds",
        "Seconds of each stage of a job, in the queue, and in total from its beginning on.",
        labels=["kind", "stage"],
    )
    for labels, measured in sorted(counts.times.items(), key=lambda item: item[0]):
        times.add_metric(labels, _buckets(measured), sum_value=measured.total)
    yield from (submitted, ended, failures, times)


def _buckets(times: Histogram) -> list[tuple[str, float]]:
    bounds = [*map(str, BUCKET_BOUNDS), "+Inf"]
    return list(zip(bounds, map(float, accumulate(times.buckets)), strict=True))


def _spectra(store: Store) -> Iterator[Metric]:
    counted = store.spectra.counts()
    spectra = CounterMetricFamily(
        "isomatch_spectra",
        "Spectra that were needed: taken from the cache (hit) or computed (miss).",
        labels=["cache"],
    )
    spectra.add_metric(["hit"], counted.hits)
    spectra.add_metric(["miss"], counted.computed)
    size = GaugeMetricFamily(
        "isomatch_spectrum_cache_bytes",
        "Size of the cached spectra.",
        value=store.spectra.cached_bytes(),
    )
    yield from (spectra, size)


def _memory(store: Store) -> Iterator[Metric]:
    used, limit = memory(store.client)
    yield GaugeMetricFamily(
        "isomatch_store_memory_bytes", "Memory that Redis uses.", value=float(used)
    )
    if limit:
        yield GaugeMetricFamily(
            "isomatch_store_memory_limit_bytes", "Memory that Redis may use.", value=float(limit)
        )
