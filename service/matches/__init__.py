"""Matches: requesting the correspondence of two shapes, or of a prototype and a shape."""

from service.matches import endpoints
from service.matches.endpoints import checked_parameters
from service.matches.schemas import SourceRequest

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS", "SourceRequest", "checked_parameters"]
