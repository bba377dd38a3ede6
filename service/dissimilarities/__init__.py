"""Dissimilarities: comparing all pairs of a collection of shapes."""

from service.dissimilarities import endpoints
from service.dissimilarities.endpoints import known_so_far
from service.dissimilarities.partial import known_matrix, number_of_pairs
from service.dissimilarities.schemas import PartialDissimilarities

ROUTERS = (endpoints.router,)

__all__ = ["ROUTERS", "PartialDissimilarities", "known_matrix", "known_so_far", "number_of_pairs"]
