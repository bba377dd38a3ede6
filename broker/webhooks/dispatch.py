"""Dispatch of webhooks: each attempt to deliver one is a job of its own.

The script that ends a job adds its webhook to a list; here a delivery job is queued for the webhook
of each tenant that is due first, unless another one of the tenant is in flight: deliveries hold
workers while receivers do not answer. Whoever runs a delivery job dispatches the next. If a job is
lost, its webhook is due again after a lease: it is delivered at least once, and may be delivered
twice.
"""

from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Annotated, Final

from pydantic import BeforeValidator, Field
from pydantic_settings import BaseSettings, NoDecode

from broker.contracts import Delivery, DeliveryPayload, DeliveryState, RequestOrigin
from broker.environment import FROM_ENVIRONMENT
from broker.queue import JobQueue
from broker.store import server_time
from broker.telemetry import logger
from broker.webhooks.addresses import Network, read_networks

INTERVAL: Final = 1.0
"""Seconds between two calls of :func:`dispatch`."""

BACKOFF_FACTOR: Final = 3.0
"""Ratio of two successive delays."""

_BATCH_SIZE: Final = 50
"""Webhooks that one call dispatches at most."""

log = logger("isomatch.webhooks")


class WebhookSettings(BaseSettings):
    """Permitted receivers, attempts and delays of webhooks; from ``ISOMATCH_*``."""

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
        default=10.0,
        gt=0,
        description="Seconds a try may take: DNS, connection and answer together.",
    )


def dispatch(queue: JobQueue, settings: WebhookSettings) -> None:
    """Queue a delivery job for each tenant with a webhook that is due, and none in flight.

    Parameters
    ----------
    queue
        The queue, and through it the store.
    settings
        Limit of the attempts.
    """
    now = server_time(queue.store.client)
    due = queue.store.of_each(lambda pipe, keys: pipe.zcount(keys.webhooks, "-inf", now))
    for tenant, count in due.items():
        if count:
            dispatch_next(queue.of(tenant), settings)


def dispatch_next(queue: JobQueue, settings: WebhookSettings) -> None:
    """Queue a delivery job for a tenant's webhook that is due first, unless one is in flight."""
    queue.submit_delivery(partial(_first_due, queue, settings))


def retry_delay(attempts: int, settings: WebhookSettings) -> timedelta:
    """Return the delay after so many attempts: exponential backoff."""
    return timedelta(seconds=settings.webhook_pause * BACKOFF_FACTOR ** (attempts - 1))


def _first_due(
    queue: JobQueue, settings: WebhookSettings
) -> tuple[DeliveryPayload, RequestOrigin] | None:
    """Return the next attempt for a tenant none of whose webhooks is in flight."""
    jobs, webhooks = queue.store.jobs, queue.store.webhooks
    for job_id in webhooks.due(_BATCH_SIZE):
        record, attempts = jobs.readable(job_id), webhooks.attempts(job_id)
        if record is None and jobs.exists(job_id):
            webhooks.postpone(job_id)
        elif record is None:
            webhooks.remove(job_id)
        elif attempts >= settings.webhook_attempts:
            _give_up(queue, job_id, attempts)
        else:
            origin = RequestOrigin(record.request_id, record.caller, traceparent=record.traceparent)
            return DeliveryPayload(job=job_id, attempt=attempts + 1), origin
    return None


def _give_up(queue: JobQueue, job_id: str, attempts: int) -> None:
    """Record that the job of the last attempt was lost."""
    lost = Delivery(
        state=DeliveryState.FAILED,
        attempts=attempts,
        last_attempt=datetime.now(UTC),
        error="the process that tried it was lost",
    )
    queue.store.webhooks.record(job_id, lost)
    log.warning("webhook given up", job_id=job_id, error=lost.error)
