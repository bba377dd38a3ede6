"""Webhooks: permitted addresses, and the dispatch of deliveries to workers."""

from broker.webhooks.addresses import literal_address, permitted, read_networks
from broker.webhooks.dispatch import INTERVAL, LEASE, WebhookSettings, dispatch, retry_delay

__all__ = [
    "INTERVAL",
    "LEASE",
    "WebhookSettings",
    "dispatch",
    "literal_address",
    "permitted",
    "read_networks",
    "retry_delay",
]
