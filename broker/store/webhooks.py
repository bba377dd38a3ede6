"""Webhooks in Redis: which are due, who tries them, and how it went."""

from dataclasses import dataclass

from redis import Redis

from broker.contracts import Delivery
from broker.store import keys, scripts
from broker.store.replies import text


@dataclass(frozen=True)
class Webhooks:
    """The webhooks that are not delivered yet, by the jobs that have ended.

    A job that ends puts itself on the list, in the same step in which its state changes.

    Parameters
    ----------
    client
        Connection to Redis.
    """

    client: Redis

    def due(self, now: float, most: int) -> list[tuple[str, float]]:
        """Return jobs whose webhook is to be tried now, and since when, the earliest first."""
        entries: list[tuple[bytes, float]] = self.client.zrangebyscore(  # type: ignore[assignment]
            keys.WEBHOOKS, "-inf", now, start=0, num=most, withscores=True
        )
        return [(text(job), since) for job, since in entries]

    def claim(self, job_id: str, since: float, until: float) -> bool:
        """Become the one who has a webhook tried, until some time; False if somebody else is."""
        return bool(self.client.eval(scripts.RESCHEDULE, 1, keys.WEBHOOKS, job_id, since, until))

    def begin(self, job_id: str, delivery_job: str, attempt: int) -> bool:
        """Note the job that is to try it, and which try it is; False if there is nothing to tell.

        That is so when the job has expired.
        """
        names = keys.job(job_id)
        return bool(self.client.eval(scripts.BEGIN_DELIVERY, 1, names, delivery_job, attempt))

    def delivery_job(self, job_id: str) -> str | None:
        """Return the job that was to try it last."""
        return text(self.client.hget(keys.job(job_id), "delivery_job"))

    def attempts(self, job_id: str) -> int:
        """Return how often it was tried."""
        return int(self.client.hget(keys.job(job_id), "attempts") or 0)

    def note(self, job_id: str, delivery: Delivery) -> None:
        """Note how it went, and when it is tried again or that it is not."""
        following = delivery.next_attempt
        self.client.eval(
            scripts.NOTE_DELIVERY,
            2,
            keys.job(job_id),
            keys.WEBHOOKS,
            job_id,
            delivery.model_dump_json(),
            "" if following is None else following.timestamp(),
        )

    def forget(self, job_id: str) -> None:
        """Take a webhook off the list whose job has expired."""
        self.client.zrem(keys.WEBHOOKS, job_id)

    def pending(self) -> int:
        """Return how many jobs that have ended have not been told of."""
        return int(self.client.zcard(keys.WEBHOOKS))
