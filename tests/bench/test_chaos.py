"""The count after faults: a short run, and defects that are planted in what it counts."""

import sys
from collections.abc import Iterator
from contextlib import closing

import pytest
from redis import Redis

from bench.chaos import TENANTS, Count, chaos, open_store, table, take_stock
from bench.load import Account
from bench.machines import Cluster, running_cluster

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")

SHORT = ("kill a job's process", "kill the API", "silence the store")
"""Faults after which the jobs go on at once."""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with running_cluster(tmp_path_factory.mktemp("chaos")) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def count(cluster: Cluster) -> Count:
    return chaos(cluster, 2.0, seed=3, faults=SHORT, callers=1, most_open=3)


def test_nothing_is_lost_in_a_short_run(count: Count, cluster: Cluster) -> None:
    assert count.clean, table(count)
    assert count.accepted > 0
    with closing(open_store(cluster)) as store:
        assert all(store.client.zcard(store.of(tenant).keys.jobs) for tenant in TENANTS)
    assert sum(count.ended.values()) == count.accepted
    assert sum(count.faults.values()) >= 1
    assert not any(name.startswith("500") for name in count.refusals)


def test_planted_defects_are_found(count: Count, cluster: Cluster) -> None:
    # None of the jobs of the run belongs to this account: all but one are more than was asked for.
    account, known = Account(), "0" * 32
    listed = cluster.http.get("/v1/jobs", params={"limit": 200}).json()["items"]
    first, *others = [job for job in listed if job["batch"] is None]
    account.jobs["missing"].add(known)
    account.jobs["twice"] |= {first["id"], known}
    with Redis.from_url(cluster.store.url) as client:
        client.set("isomatch:job:x:result", "left for ever")
        client.set("isomatch:job:y:result", "left for a while", ex=1000)
        client.delete(f"isomatch:job:{first['id']}:result")
        found = Count()
        take_stock(cluster, {cluster.http: account}, found)
        client.delete("isomatch:job:x:result", "isomatch:job:y:result")
    assert f"{known}: unknown" in found.lost
    assert (f"{first['id']}: its result" in found.lost) == (first["state"] == "succeeded")
    assert f"key twice: {sorted([first['id'], known])}" in found.duplicated
    assert sum("of no key" in one for one in found.duplicated) == len(others)
    assert found.without_ttl == ["isomatch:job:x:result"]
    assert not found.clean
    assert "without_ttl: isomatch:job:x:result" in table(found)
