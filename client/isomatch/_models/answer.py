"""Base of all answers of the service, and pages of listings.

Fields that this version does not know are ignored, so that a newer service can be used; missing
fields and numbers that are not finite are errors.
"""

from typing import Generic, TypeVar

from pydantic import BaseModel, ConfigDict

ItemT = TypeVar("ItemT")


class Answer(BaseModel):
    """A value that the service answers; immutable."""

    # Validators of most models are needed by no command: building all takes a tenth of a second.
    model_config = ConfigDict(frozen=True, extra="ignore", defer_build=True)


class Page(Answer, Generic[ItemT]):
    """One page of a listing, and the cursor of the next."""

    items: tuple[ItemT, ...]
    next_cursor: str | None
