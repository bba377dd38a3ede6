"""Dissimilarities: comparing a collection of shapes."""

from service.dissimilarities.endpoints import known_so_far
from service.dissimilarities.partial import known_matrix, number_of_pairs
from service.dissimilarities.schemas import PartialDissimilarities

__all__ = ["PartialDissimilarities", "known_matrix", "known_so_far", "number_of_pairs"]
