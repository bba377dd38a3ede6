"""Webhooks that are due are given to jobs of their own, one for each try.

The job that ends puts its webhook on a list in the same step; here somebody looks at the list and
queues a job for each that is due. Should that job be lost, with its worker or before it was queued,
the webhook is due again after a while: receivers may be told twice, but they are told.
"""

import time
from datetime import UTC, datetime, timedelta
from typing import Annotated, Final

from pydantic import BeforeValidator, Field
from pydantic_settings import BaseSettings, NoDecode

from broker.contracts import Delivery, DeliveryPayload, DeliveryState, JobRecord, Order
from broker.environment import FROM_ENVIRONMENT
from broker.queue import JobQueue, new_job
from broker.store import NewerRecord
from broker.telemetry import logger
from broker.webhooks.addresses import Network, read_networks

INTERVAL: Final = 1.0
"""Seconds between two rounds of :func:`dispatch`."""

LEASE: Final = 60.0
"""Seconds after which a webhook is due again of whose try nothing was heard."""

GROWTH: Final = 3.0
"""How many times longer each pause is than the one before."""

_AT_ONCE: Final = 50

log = logger("isomatch.webhooks")


class WebhookSettings(BaseSettings):
    """Where webhooks may go and how often they are tried; from ``ISOMATCH_*``."""

    model_config = FROM_ENVIRONMENT

    webhook_networks: Annotated[tuple[Network, ...], NoDecode, BeforeValidator(read_networks)] = (
        Field(
            default=(),
            description="Networks that webhooks may go to although they are not public, such as"
            " 10.0.0.0/8, separated by commas.",
        )
    )
    webhook_attempts: int = Field(default=8, ge=1, description="How often a webhook is tried.")
    webhook_pause: float = Field(
        default=5.0,
        gt=0,
        description="Seconds before the second try; each further pause is three times as long.",
    )
    webhook_timeout: float = Field(
        default=10.0, gt=0, description="Seconds a receiver may take to answer."
    )


def dispatch(queue: JobQueue, settings: WebhookSettings) -> None:
    """Queue a job for each webhook that is due.

    Parameters
    ----------
    queue
        Where to, and through it the store.
    settings
        How often a webhook is tried.
    """
    webhooks, now = queue.store.webhooks, time.time()
    for job_id, since in webhooks.due(now, _AT_ONCE):
        if not webhooks.claim(job_id, since, now + LEASE):
            continue
        try:
            record = queue.store.jobs.get(job_id)
        except NewerRecord:
            continue
        if record is None:
            webhooks.forget(job_id)
        elif not _being_tried(queue, job_id):
            _try(queue, record, settings)


def pause(attempts: int, settings: WebhookSettings) -> timedelta:
    """Return how long to wait after so many tries."""
    return timedelta(seconds=settings.webhook_pause * GROWTH ** (attempts - 1))


def _being_tried(queue: JobQueue, job_id: str) -> bool:
    last = queue.store.webhooks.delivery_job(job_id)
    state = None if last is None else queue.store.jobs.state(last)
    return state is not None and not state.ended


def _try(queue: JobQueue, record: JobRecord, settings: WebhookSettings) -> None:
    webhooks = queue.store.webhooks
    if webhooks.attempts(record.id) >= settings.webhook_attempts:
        # The last try was never heard of again.
        lost = Delivery(
            state=DeliveryState.FAILED,
            attempts=webhooks.attempts(record.id),
            last_attempt=datetime.now(UTC),
            error="the process that tried it was lost",
        )
        webhooks.note(record.id, lost)
        log.warning("webhook given up", job_id=record.id, error=lost.error)
        return
    order = Order(record.request_id, record.caller)
    attempt = webhooks.attempts(record.id) + 1
    job = new_job(DeliveryPayload(job=record.id, attempt=attempt), order)
    if webhooks.begin(record.id, job.id, attempt):
        queue.submit(job)
    else:
        webhooks.forget(record.id)
