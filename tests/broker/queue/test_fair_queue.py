"""The fair queue: order within a flow, and shares between flows."""

import time
from collections import Counter

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rq.executions import ExecutionRegistry
from rq.job import Job
from rq.serializers import JSONSerializer

from broker.queue import FairQueue
from broker.queue.fair_queue import Share
from broker.store import Store

A, B, C = (Share(name, 1.0, 0.0) for name in "ABC")
QUICK = Share("A/quick", 0.25, 1.0)


class Turns:
    """A queue whose jobs are named by their flow and number.

    Parameters
    ----------
    store
        Its Redis.
    """

    def __init__(self, store: Store) -> None:
        self.client = store.client
        self.client.flushdb()
        self.queue = FairQueue("turns", connection=store.client, serializer=JSONSerializer)
        self.pushed: Counter[str] = Counter()

    def push(self, share: Share, count: int = 1) -> list[str]:
        """Queue jobs of a flow, and return their ids."""
        return [self._push(share) for _ in range(count)]

    def _push(self, share: Share) -> str:
        self.pushed[share.flow] += 1
        name = f"{share.flow.replace('/', '-')}-{self.pushed[share.flow]}"
        self.queue.enqueue_call("nothing", job_id=name, meta=share.meta())
        return name

    def take(self, count: int = 1) -> list[str]:
        """Take jobs as a worker does."""
        taken = self.waiting[:count]
        for job in taken:
            assert self.queue.pop_job_id() == job
        return taken

    def withdraw(self, job: str) -> None:
        """Withdraw a job that waits."""
        self.queue.withdraw(Job.fetch(job, connection=self.client, serializer=JSONSerializer))

    @property
    def waiting(self) -> list[str]:
        """Ids of the waiting jobs, in order."""
        return self.queue.get_job_ids()


@pytest.fixture
def turns(store: Store) -> Turns:
    return Turns(store)


def test_jobs_of_one_flow_are_served_in_the_order_they_came(turns: Turns) -> None:
    first = turns.push(A, 12)
    assert turns.take(5) == first[:5]
    assert turns.take(20) == first[5:]
    assert turns.take() == []
    assert turns.take() == [] == turns.waiting
    again = turns.push(A, 3)
    assert turns.waiting == again


def test_a_thousand_jobs_of_one_do_not_keep_another_waiting(turns: Turns) -> None:
    turns.push(A, 1000)
    turns.take(17)
    (mine,) = turns.push(B)
    assert turns.take() == [mine]
    # Nor if nothing was queued while hundreds were served.
    turns.take(400)
    (mine,) = turns.push(C)
    assert turns.take() == [mine]


def test_two_that_wait_are_served_in_turn(turns: Turns) -> None:
    turns.push(A, 50)
    turns.take(20)
    turns.push(B, 10)
    assert [job[0] for job in turns.take(20)] == ["B", "A"] * 10
    assert {job[0] for job in turns.take(50)} == {"A"}


def test_who_was_away_gets_no_more_than_a_turn(turns: Turns) -> None:
    turns.push(A, 5)
    turns.push(B, 200)
    turns.take(100)
    turns.push(A, 100)
    served = Counter(job[0] for job in turns.take(60))
    assert abs(served["A"] - served["B"]) <= 1


def test_cheap_jobs_come_first_until_their_lead_is_used(turns: Turns) -> None:
    turns.push(A, 30)
    turns.take(10)
    turns.push(QUICK, 40)
    order = [job.startswith("A-quick") for job in turns.take(25)]
    # A lead of 1 is four jobs of a quarter, besides the four for each of the others.
    assert order[:8] == [True] * 8
    assert sum(order[8:]) == pytest.approx(0.8 * len(order[8:]), abs=1)


def test_what_was_withdrawn_is_not_charged(turns: Turns) -> None:
    turns.push(A, 20)
    withdrawn = turns.push(B, 20)
    for job in withdrawn:
        turns.withdraw(job)
    turns.take(3)
    (mine,) = turns.push(B)
    assert turns.take() == [mine]


def test_what_a_worker_has_taken_is_not_withdrawn(turns: Turns) -> None:
    turns.push(A, 2)
    (taken,), (waits,) = turns.take(), turns.waiting
    for job in (taken, waits):
        # What is left of an execution while a worker ends it, and of one that was lost.
        turns.client.zadd(ExecutionRegistry(job, turns.client).key, {"half": time.time() + 60})
        turns.withdraw(job)
    assert turns.client.exists(Job.key_for(taken))
    assert not turns.client.exists(Job.key_for(waits))
    assert turns.waiting == []


def test_a_job_that_is_queued_again_waits_once_and_where_it_belongs(turns: Turns) -> None:
    turns.push(A, 6)
    (lost,) = turns.take()
    job = Job.fetch(lost, connection=turns.client, serializer=JSONSerializer)
    turns.queue.enqueue_job(job)
    assert turns.waiting == [f"A-{number}" for number in (2, 3, 4, 5, 6, 1)]


def test_a_job_that_was_lost_is_next_and_its_flow_is_not_charged_again(turns: Turns) -> None:
    lost, *mine = turns.push(A, 3)
    others = turns.push(B, 3)
    assert turns.take() == [lost]
    turns.queue.push_job_id(lost, at_front=True)
    more = turns.push(C)
    assert turns.waiting == [lost, others[0], *more, mine[0], others[1], mine[1], others[2]]
    assert turns.take() == [lost]


def test_jobs_of_an_older_version_keep_their_place(turns: Turns) -> None:
    turns.client.rpush(turns.queue.key, "old-1", "old-2")
    turns.push(A, 3)
    turns.client.rpush(turns.queue.key, "old-3")
    turns.push(B, 1)
    assert turns.waiting == ["old-1", "old-2", "A-1", "B-1", "A-2", "A-3", "old-3"]


def test_the_state_of_a_queue_expires(turns: Turns) -> None:
    turns.push(A, 3)
    turns.push(B)
    state = list(turns.client.keys(f"{turns.queue.key}:*"))
    assert len(state) == 4
    assert all(0 < turns.client.ttl(key) <= 7 * 86400 for key in state)


FLOWS = (A, B, C, Share("D", 0.25, 1.0), Share("E", 0.5, 1.0))
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("push"), st.sampled_from(FLOWS), st.integers(1, 9)),
        st.tuples(st.just("take"), st.none(), st.integers(1, 9)),
        st.tuples(st.just("withdraw"), st.none(), st.integers(0, 40)),
    ),
    max_size=40,
)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(STEPS)
def test_flows_that_wait_get_equal_shares(
    store: Store, steps: list[tuple[str, Share | None, int]]
) -> None:
    turns = Turns(store)
    shares = {share.flow: share for share in FLOWS}
    # What each pair was served since both began to wait without a break.
    owed: dict[tuple[str, str], float] = {}
    last: dict[str, int] = {}
    for step, share, number in steps:
        if step == "push":
            assert share is not None
            turns.push(share, number)
        elif step == "withdraw":
            waiting = turns.waiting
            if number < len(waiting):
                turns.withdraw(waiting[number])
                owed.clear()
        else:
            for _ in range(number):
                waits = sorted({job[0] for job in turns.waiting})
                pairs = {(a, b) for a in waits for b in waits if a < b}
                owed = {pair: owed.get(pair, 0.0) for pair in pairs}
                for job in turns.take():
                    flow, _, count = job.partition("-")
                    # In order within the flow.
                    assert int(count) > last.get(flow, 0)
                    last[flow] = int(count)
                    for pair in owed:
                        if flow in pair:
                            owed[pair] += shares[flow].cost * (1 if flow == pair[0] else -1)
                for (a, b), difference in owed.items():
                    bound = sum(shares[flow].cost + shares[flow].lead for flow in (a, b))
                    assert abs(difference) <= bound + 1e-9
