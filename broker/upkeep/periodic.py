"""Periodic upkeep, which all API processes do together: each task is done by one of them at a time.

Whoever begins a task says so for as long as nobody need do it again. Nothing is taken back at the
end, nor when a process dies: another one begins when the time is over.
"""

from dataclasses import dataclass

from broker.queue import JobQueue
from broker.store import Keys
from broker.upkeep.recovery import clock_is_right, recover
from broker.upkeep.retention import Sweep
from broker.webhooks import INTERVAL, WebhookSettings, dispatch


@dataclass(frozen=True)
class Upkeep:
    """Tasks that each process calls as often as they are to be done.

    Parameters
    ----------
    queue
        The queue and, through it, the store.
    webhooks
        Limit of the attempts to deliver one.
    """

    queue: JobQueue
    webhooks: WebhookSettings

    def recover(self) -> None:
        """Recover lost jobs, unless the clock of this process is wrong; once in a heartbeat."""
        if clock_is_right(self.queue) and self._is_due("recovery", self.queue.settings.heartbeat):
            recover(self.queue)

    def sweep(self) -> None:
        """Sweep the next parts of the listings, once in a heartbeat."""
        if self._is_due("sweep", self.queue.settings.heartbeat):
            Sweep(self.queue.store).step()

    def dispatch(self) -> None:
        """Queue the webhooks that are due, once in :data:`~broker.webhooks.INTERVAL`."""
        if self._is_due("webhooks", INTERVAL):
            dispatch(self.queue, self.webhooks)

    def _is_due(self, task: str, seconds: float) -> bool:
        name = Keys.periodic(task)
        return bool(self.queue.store.client.set(name, b"", nx=True, px=int(1000 * seconds)))
