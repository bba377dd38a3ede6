"""Shapes as requests name them."""

from collections.abc import Mapping
from typing import Annotated

from fastapi import Path

from broker.contracts import FieldProblem, ShapeRecord
from service.dependencies import Service
from service.http import ApiProblem, ShapeExpired, ShapeNotFound, UnknownShape
from service.names import ID_PATTERN

ShapeId = Annotated[str, Path(description="Id of the shape.", pattern=ID_PATTERN)]


def missing_shape(service: Service, shape: str) -> ApiProblem:
    """Return the problem that a shape is not there."""
    if service.store.shapes.expired(shape):
        return ShapeExpired(
            "The shape was not used for long and is no longer kept; upload it again."
        )
    return ShapeNotFound(f"There is no shape {shape}.")


def use_shapes(service: Service, named: Mapping[str, str]) -> dict[str, ShapeRecord]:
    """Return the shapes that a request names, and prolong their lives until the job begins.

    Parameters
    ----------
    service
        The service that keeps them.
    named
        Ids of the shapes by the fields that name them, such as ``body.source``.

    Returns
    -------
    Their records, by the same fields.

    Raises
    ------
    UnknownShape
        A shape does not exist, or has expired.
    """
    shapes = service.store.shapes
    used = shapes.use_all(list(named.values())) if named else []
    found = dict(zip(named, used, strict=True))
    unknown = tuple(
        FieldProblem(
            field=field,
            message=f"shape {shape} was not used for long and is no longer kept; upload it again"
            if shapes.expired(shape)
            else f"there is no shape {shape}",
        )
        for field, shape in named.items()
        if found[field] is None
    )
    if unknown:
        raise UnknownShape("Upload the shapes first; `errors` names the unknown ones.", unknown)
    return {field: record for field, record in found.items() if record is not None}
