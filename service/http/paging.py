"""Pages of a listing, as query parameters."""

from collections.abc import Callable
from typing import Annotated, TypeVar

from fastapi import Query

from broker.contracts import FieldProblem
from broker.store import InvalidCursor, Page
from service.http.problems import INVALID, InvalidRequest

ItemT = TypeVar("ItemT")

Limit = Annotated[int, Query(ge=1, le=200, description="Most items on a page.")]
Cursor = Annotated[
    str | None,
    Query(
        max_length=200, description="`next_cursor` of the page before; leave it out for the first."
    ),
]


def page_of(fetch: Callable[[], Page[ItemT]]) -> Page[ItemT]:
    """Fetch a page.

    Raises
    ------
    InvalidRequest
        The cursor is not the `next_cursor` of a page.
    """
    try:
        return fetch()
    except InvalidCursor as error:
        fields = (FieldProblem(field="query.cursor", message=str(error)),)
        raise InvalidRequest(INVALID, fields) from error
