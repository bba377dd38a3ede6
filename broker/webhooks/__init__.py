"""Webhooks: which addresses are permitted, and the dispatch of deliveries to workers."""

from broker.webhooks.addresses import literal_address, permitted, read_networks
from broker.webhooks.dispatch import INTERVAL, LEASE, WebhookSettings, dispatch, pause

__all__ = [
    "INTERVAL",
    "LEASE",
    "WebhookSettings",
    "dispatch",
    "literal_address",
    "pause",
    "permitted",
    "read_networks",
]
