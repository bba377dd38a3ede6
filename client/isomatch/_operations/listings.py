"""Listings, which the service answers page by page."""

from collections.abc import Mapping
from typing import TypeVar

from isomatch._http import Call, Item, Operation, Stream, parsed, send, with_retries
from isomatch._models import Page

ItemT = TypeVar("ItemT")


def list_all(
    kind: type[Page[ItemT]], path: str, retries: int, query: Mapping[str, str | None]
) -> Stream[ItemT]:
    """Yield all items of a listing.

    Parameters
    ----------
    kind
        Type of a page.
    path, query
        Path of the listing, and which of its items.
    retries
        Greatest number of repetitions of the request for a page.
    """
    page = yield from with_retries(_page(kind, path, query), retries)
    while True:
        for item in page.items:
            yield Item(item)
        if page.next_cursor is None:
            return
        following = _page(kind, path, {**query, "cursor": page.next_cursor})
        page = yield from with_retries(following, retries)


def _page(
    kind: type[Page[ItemT]], path: str, query: Mapping[str, str | None]
) -> Operation[Page[ItemT]]:
    return parsed(kind, (yield from send(Call("GET", path, query=query))))
