"""Shapes as requests name them."""

from collections.abc import Mapping
from typing import Annotated, Final

from fastapi import Path

from broker.contracts import FieldProblem, ShapeRecord, is_prototype
from service.dependencies import Service
from service.http import ShapeDeleted, ShapeExpired, ShapeNotFound, UnknownShape
from service.names import ID_PATTERN
from service.uploads import UploadKind

ShapeId = Annotated[str, Path(description="Id of the shape.", pattern=ID_PATTERN)]

PATH: Final = "/v1/shapes"

SHAPES: Final = UploadKind[ShapeRecord](
    "shape",
    lambda store: store.shapes,
    "upload it again",
    ShapeNotFound,
    ShapeExpired,
    ShapeDeleted,
    path=PATH,
    location=PATH,
)


def _unknown(service: Service, field: str, shape: str) -> FieldProblem:
    if is_prototype(shape):
        message = f"{shape} is a prototype, which can only be the `source` of a match or batch"
        return FieldProblem(field=field, message=message)
    return SHAPES.unknown(service, field, shape)


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
    used = service.store.shapes.use_all(list(named.values())) if named else []
    found = dict(zip(named, used, strict=True))
    unknown = tuple(
        _unknown(service, field, shape) for field, shape in named.items() if found[field] is None
    )
    if unknown:
        raise UnknownShape("Upload the shapes first; `errors` names the unknown ones.", unknown)
    return {field: record for field, record in found.items() if record is not None}
