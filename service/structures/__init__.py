"""Structures: the metrics and descriptors that shapes can be compared by."""

from service.structures import endpoints

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS"]
