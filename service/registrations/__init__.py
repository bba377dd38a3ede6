"""Registrations: one template on many specimens, and the statistics of their shapes."""

from service.registrations import endpoints

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS"]
