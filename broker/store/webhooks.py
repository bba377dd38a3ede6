"""Webhooks in Redis: when each is due, the job that delivers it, and the outcome."""

from dataclasses import dataclass
from typing import cast

from broker.contracts import Delivery
from broker.store import scripts
from broker.store.replies import text
from broker.store.tenant_data import TenantData


@dataclass(frozen=True)
class Webhooks(TenantData):
    """The webhooks that are not delivered yet, by the jobs that have ended.

    The script that ends a job adds its webhook to the list.
    """

    def due(self, now: float, most: int) -> list[tuple[str, float]]:
        """Return jobs whose webhook is due, and since when, the earliest first."""
        entries = self.client.zrangebyscore(
            self.keys.webhooks, "-inf", now, start=0, num=most, withscores=True
        )
        return [(text(job), since) for job, since in cast(list[tuple[bytes, float]], entries)]

    def claim(self, job_id: str, since: float, until: float) -> bool:
        """Postpone a webhook that is due; False if another process has."""
        return bool(scripts.CLAIM_WEBHOOK(self.client, [self.keys.webhooks], job_id, since, until))

    def begin(self, job_id: str, delivery_job: str, attempt: int) -> bool:
        """Store the delivery's job and attempt; False if the job itself has expired."""
        names = [self.keys.job(job_id)]
        return bool(scripts.BEGIN_DELIVERY(self.client, names, delivery_job, attempt))

    def delivery_job(self, job_id: str) -> str | None:
        """Return the job of the last attempt."""
        return text(self.client.hget(self.keys.job(job_id), "delivery_job"))

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

    def pending(self) -> int:
        """Return the number of webhooks that are not delivered yet."""
        return int(self.client.zcard(self.keys.webhooks))
