"""Batches: matching one source with many targets."""

from service.batches import endpoints

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS"]
