"""Code that API and workers share: contracts, the store in Redis, queues, webhooks, upkeep.

Nothing here imports numerics, so that the API process does not load them.
"""
