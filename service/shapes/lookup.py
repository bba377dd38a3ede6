"""Shapes as requests name them, and what is said of one that is not there."""

from typing import Annotated

from fastapi import Path

from service.http import ApiProblem, ShapeExpired, ShapeNotFound
from service.state import Service

ShapeId = Annotated[str, Path(description="Id of the shape.", pattern=r"^[0-9a-zA-Z_-]{1,64}$")]


def missing_shape(service: Service, shape: str) -> ApiProblem:
    """Return what is said of a shape that is not there."""
    if service.store.shapes.expired(shape):
        return ShapeExpired(
            "The shape was not used for long and is no longer kept; upload it again."
        )
    return ShapeNotFound(f"There is no shape {shape}.")
