"""Prototypes: learning, listing, exchanging and deleting what classes of shapes are like."""
