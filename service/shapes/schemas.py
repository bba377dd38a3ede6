"""Shapes as the API shows them."""

from pydantic import BaseModel, Field

from broker.contracts import ShapeRecord


class Shape(ShapeRecord):
    """An uploaded shape."""


class ShapePage(BaseModel):
    """One page of the shapes, the newest first."""

    items: tuple[Shape, ...]
    next_cursor: str | None = Field(description="Cursor of the next page; null on the last.")
