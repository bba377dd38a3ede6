"""Dissimilarities: comparing all pairs of a collection of shapes."""

from service.dissimilarities import endpoints

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS"]
