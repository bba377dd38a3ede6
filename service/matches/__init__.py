"""Matches: asking for the correspondence of two shapes."""
