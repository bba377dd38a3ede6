"""What the API and the workers share: contracts, the store in Redis, the queue, webhooks, upkeep.

Nothing here computes: the API process imports it without any numerics.
"""
