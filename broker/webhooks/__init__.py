"""Webhooks: permitted addresses, and the dispatch of deliveries to workers."""

from broker.webhooks.addresses import literal_address, permitted
from broker.webhooks.dispatch import (
    INTERVAL,
    WebhookSettings,
    dispatch,
    dispatch_next,
    retry_delay,
)

__all__ = [
    "INTERVAL",
    "WebhookSettings",
    "dispatch",
    "dispatch_next",
    "literal_address",
    "permitted",
    "retry_delay",
]
