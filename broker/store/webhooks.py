"""Webhooks in Redis: when each is due, the attempts to deliver it, and the outcome."""

from dataclasses import dataclass
from typing import Final, cast

from redis import Redis
from redis.client import Pipeline

from broker.contracts import Delivery
from broker.store import scripts
from broker.store.connections import server_time
from broker.store.replies import text
from broker.store.tenant_data import TenantData

LEASE: Final = 60.0
"""Seconds after which a webhook is due again whose delivery was lost or whose job is unreadable."""


@dataclass(frozen=True)
class Webhooks(TenantData):
    """The webhooks that are not delivered yet, by the jobs that have ended.

    The script that ends a job adds its webhook to the list.
    """

    def due(self, most: int) -> list[str]:
        """Return jobs whose webhook is due, the earliest first."""
        now = server_time(self.client)
        found = self.client.zrangebyscore(self.keys.webhooks, "-inf", now, start=0, num=most)
        return list(map(text, cast(list[bytes], found)))

    def postpone(self, job_id: str, client: Redis | None = None) -> None:
        """Make a webhook that is in the list due again after :data:`LEASE`."""
        later = {job_id: server_time(self.client) + LEASE}
        (client or self.client).zadd(self.keys.webhooks, later, xx=True)

    def begin(self, job_id: str, attempt: int, pipe: Pipeline) -> None:
        """Count an attempt, and postpone the next, as part of a transaction."""
        scripts.BEGIN_DELIVERY(pipe, [self.keys.job(job_id)], attempt)
        self.postpone(job_id, pipe)

    def attempts(self, job_id: str) -> int:
        """Return the number of attempts."""
        return int(self.client.hget(self.keys.job(job_id), "attempts") or 0)

    def record(self, job_id: str, delivery: Delivery) -> None:
        """Store the outcome of an attempt, and schedule the next one if there is to be one."""
        due = "" if delivery.next_attempt is None else delivery.next_attempt.timestamp()
        names = [self.keys.job(job_id), self.keys.webhooks]
        scripts.RECORD_DELIVERY(self.client, names, job_id, delivery.model_dump_json(), due)

    def remove(self, job_id: str) -> None:
        """Remove a webhook from the list."""
        self.client.zrem(self.keys.webhooks, job_id)
