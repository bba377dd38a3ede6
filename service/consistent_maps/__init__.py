"""Consistent maps between all shapes of a collection."""

from service.consistent_maps import endpoints

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS"]
