"""Structures: what can be compared of shapes."""
