"""Dissimilarities: comparing a collection of shapes."""
