"""Matches: requesting the correspondence of two shapes, or of a prototype and a shape."""

from service.matches import endpoints

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS"]
