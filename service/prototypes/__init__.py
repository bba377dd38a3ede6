"""Prototypes: learning, uploading, listing, fetching and deleting them."""

from service.prototypes import archives, endpoints
from service.prototypes.lookup import PATH as ARCHIVES_PATH
from service.prototypes.lookup import use_prototype

ROUTERS = (archives.router, endpoints.router)

__all__ = ["ARCHIVES_PATH", "ROUTERS", "use_prototype"]
