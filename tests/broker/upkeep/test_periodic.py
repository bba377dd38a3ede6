"""Upkeep that several processes share: each task is done once in its interval, by any of them."""

import time
from collections.abc import Callable

import pytest

from broker.contracts import MatchParameters, MatchPayload, RequestOrigin, Webhook
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Keys
from broker.store.webhooks import LEASE
from broker.upkeep import Upkeep, recover
from broker.webhooks import INTERVAL, WebhookSettings, dispatch
from service.monitoring import StoreCollector

MATCH = MatchPayload(source="a", target="b", parameters=MatchParameters())

TASKS = pytest.mark.parametrize(
    ("name", "task", "seconds"),
    [
        ("recovery", Upkeep.recover, 5.0),
        ("sweep", Upkeep.sweep, 5.0),
        ("webhooks", Upkeep.dispatch, INTERVAL),
    ],
)


def passes(queue: JobQueue) -> int:
    """How often all tenants were looked through."""
    stats = queue.store.client.info("commandstats")
    return int(stats.get("cmdstat_smembers", {"calls": 0})["calls"])


@TASKS
def test_several_processes_do_a_task_once(
    queue: JobQueue, name: str, task: Callable[[Upkeep], None], seconds: float
) -> None:
    client, before = queue.store.client, passes(queue)
    for _ in range(3):
        task(Upkeep(queue, WebhookSettings()))
    assert passes(queue) - before == 1
    # Whoever began it may have died: another one does when the time is over.
    assert 0 < client.pttl(Keys.periodic(name)) <= 1000 * seconds
    client.delete(Keys.periodic(name))
    task(Upkeep(queue, WebhookSettings()))
    assert passes(queue) - before == 2


def test_idle_tenants_cost_no_round_trips(queue: JobQueue) -> None:
    tenants = [queue.of(f"tenant{number}") for number in range(50)]
    for one in tenants:
        one.cancel(one.submit(MATCH).id)
    upkeep, settings = Upkeep(queue, WebhookSettings()), WebhookSettings()
    collector = StoreCollector(queue)
    tasks: list[Callable[[], object]] = [
        lambda: recover(queue),
        upkeep.sweep,
        lambda: dispatch(queue, settings),
        lambda: list(collector.collect()),
    ]
    for task in tasks:
        before = queue.store.client.info("stats")["total_reads_processed"]
        task()
        assert queue.store.client.info("stats")["total_reads_processed"] - before < len(tenants)


@pytest.mark.parametrize("ahead", [-3600.0, 3600.0])
def test_webhooks_are_dispatched_whatever_the_clock_of_the_process(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch, ahead: float
) -> None:
    store, clock = queue.store, time.time
    job = queue.submit(MATCH, RequestOrigin(webhook=Webhook(url="http://example.org/"))).id
    assert store.jobs.claim(job, "me")
    assert store.jobs.succeed(job, "me", b"{}")
    monkeypatch.setattr(time, "time", lambda: clock() + ahead)
    Upkeep(queue, WebhookSettings()).dispatch()
    assert store.client.exists(DEFAULT_KEYS.delivery)
    due = store.client.zscore(DEFAULT_KEYS.webhooks, job)
    assert due is not None
    assert 0 < due - clock() <= LEASE
