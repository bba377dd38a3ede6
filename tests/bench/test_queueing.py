"""The simulation of many workers: where it has a closed form."""

from dataclasses import replace

import pytest

from bench.queueing import Load, simulate

LOAD = Load(processor=1.0, store=1e-6, turns=5, network=0.0, heartbeats=0.0)


@pytest.mark.parametrize("workers", [1, 8, 100])
def test_workers_with_processors_of_their_own_are_always_busy(workers: int) -> None:
    found = simulate(LOAD, workers, workers, 4000)
    assert found.rate == pytest.approx(workers, rel=0.05)
    assert found.workers == pytest.approx(1.0, abs=0.02)


def test_processors_bound_workers() -> None:
    assert simulate(LOAD, 8, 2, 4000).rate == pytest.approx(2.0, rel=0.05)


def test_one_redis_bounds_all() -> None:
    busy = replace(LOAD, store=0.01)
    found = simulate(busy, 1000, 1000, 20000)
    assert found.rate == pytest.approx(100.0, rel=0.05)
    assert found.store == pytest.approx(1.0, abs=0.02)
    # Heartbeats take half of it.
    beating = replace(busy, heartbeats=0.0005)
    assert simulate(beating, 1000, 1000, 20000).rate == pytest.approx(50.0, rel=0.05)
    with pytest.raises(ValueError, match="heartbeats"):
        simulate(replace(busy, heartbeats=0.001), 1000, 1000, 100)


def test_in_round_trips_nothing_is_busy() -> None:
    waiting = replace(LOAD, network=0.2)
    found = simulate(waiting, 10, 10, 4000)
    assert found.rate == pytest.approx(10 / 2.0, rel=0.05)
    assert found.store < 0.01


def test_a_closed_queue_of_one_server() -> None:
    """Machine repair: two workers, one server, equal exponential times; 4/5 of the server used."""
    even = Load(processor=1.0, store=1.0, turns=1, network=0.0, heartbeats=0.0)
    found = simulate(even, 2, 2, 40000)
    assert found.store == pytest.approx(0.8, abs=0.02)
    assert found.rate == pytest.approx(0.8, rel=0.03)
