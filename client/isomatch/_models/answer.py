"""Base of all answers of the service, and pages of listings.

Fields that this version does not know are ignored, so that a newer service can be used; missing
fields and numbers that are not finite are errors.
"""

from typing import Any, Generic, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict

ItemT = TypeVar("ItemT")


class Answer(BaseModel):
    """A value that the service answers; immutable."""

    # Validators of most models are needed by no command: building all takes a tenth of a second.
    model_config = ConfigDict(frozen=True, extra="ignore", defer_build=True)

    def __eq__(self, other: object) -> bool:
        # Pydantic compares arrays by ==, also those of cached properties, and the bytes of answers.
        if type(self) is not type(other):
            return NotImplemented
        fields = type(self).model_fields
        return all(_equal(getattr(self, name), getattr(other, name)) for name in fields)


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return bool(one == other)


class Page(Answer, Generic[ItemT]):
    """One page of a listing, and the cursor of the next."""

    items: tuple[ItemT, ...]
    next_cursor: str | None
