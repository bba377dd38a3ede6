"""Comparison of shapes, section 6.2: signatures, dissimilarities, retrieval."""

from solver.similarity.dissimilarity import (
    SignatureCollection,
    dissimilarities,
    number_of_pairs,
    pairs_between,
)
from solver.similarity.retrieval import RetrievalScores, rankings, retrieval_scores
from solver.similarity.signature import SAMPLINGS, Signature, SimilarityOptions, signature

__all__ = [
    "SAMPLINGS",
    "RetrievalScores",
    "Signature",
    "SignatureCollection",
    "SimilarityOptions",
    "dissimilarities",
    "number_of_pairs",
    "pairs_between",
    "rankings",
    "retrieval_scores",
    "signature",
]
