"""Vertices of files, by their numbers."""

from typing import Annotated, TypeAlias

from pydantic import BeforeValidator, Field

from broker.contracts.strict import Items, integral

Vertex: TypeAlias = Annotated[int, Field(ge=0, le=2**53, strict=True), BeforeValidator(integral)]
Landmark: TypeAlias = Annotated[tuple[Vertex, ...], Items(2, 2)]
"""A vertex of the source's file and one of the target's."""
