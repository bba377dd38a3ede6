"""Records of shapes without an upload."""

from datetime import UTC, datetime
from typing import Any

from broker.contracts import ShapeRecord

CREATED = datetime(2026, 1, 1, tzinfo=UTC)


def shape_record(shape: str, **fields: Any) -> ShapeRecord:
    """The record of a triangle, with other values for the given fields."""
    triangle: dict[str, Any] = {
        "name": shape,
        "file_type": "off",
        "kind": "mesh",
        "bytes": 4,
        "vertices": 3,
        "faces": 1,
        "area": 1.0,
        "components": 1,
        "closed": True,
        "has_colors": False,
        "warnings": (),
        "created": CREATED,
    }
    return ShapeRecord(id=shape, **(triangle | fields))
