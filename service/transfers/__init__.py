"""Transfers: attribute files, and carrying them or landmarks along a match."""

from service.transfers import attributes, endpoints
from service.transfers.attributes import PATH as ATTRIBUTES_PATH

ROUTERS = (attributes.router, endpoints.router)

__all__ = ["ATTRIBUTES_PATH", "ROUTERS"]
