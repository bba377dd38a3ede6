"""Shapes as the API shows them."""

from pydantic import BaseModel, ConfigDict, Field

from broker.contracts import ShapeRecord


class Shape(ShapeRecord):
    """An uploaded shape."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True)


class ShapePage(BaseModel):
    """One page of the shapes, the newest first."""

    items: tuple[Shape, ...] = Field(description="The shapes.")
    next_cursor: str | None = Field(description="Cursor of the next page; null on the last.")
