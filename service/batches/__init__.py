"""Batches: matching one source with many targets."""

from service.batches import endpoints
from service.batches.schemas import BatchProgress

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS", "BatchProgress"]
