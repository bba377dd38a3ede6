"""Listings in pages, newest first; a cursor stays valid while entries come and go."""

import base64
import binascii
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Final, Generic, TypeVar, cast

from redis import Redis

from broker.store import scripts
from broker.store.replies import text

ItemT = TypeVar("ItemT")

SWEEP_COUNT: Final = 500
"""Entries that one step of a sweep looks at, as a hint to Redis."""

MOST_SKIPPED: Final = 1000
"""Entries that one page skips, after which it ends."""

_NO_PAGE: Final = "no page of this listing, with these filters, has this cursor"


class InvalidCursor(ValueError):
    """A cursor that no page has."""


@dataclass(frozen=True)
class Page(Generic[ItemT]):
    """One page of a listing, and the cursor of the next one if there may be more."""

    items: tuple[ItemT, ...]
    next_cursor: str | None


@dataclass(frozen=True)
class Listing:
    """A sorted set of ids by time.

    Parameters
    ----------
    client
        Connection to Redis.
    key
        The sorted set.
    record
        Returns the key of an entry's record.
    """

    client: Redis
    key: str
    record: Callable[[str], str]

    def page(
        self,
        limit: int,
        cursor: str | None,
        fetch: Callable[[Sequence[str]], Sequence[ItemT | None]],
        matches: Callable[[ItemT], bool] = lambda item: True,
        filters: str = "",
        may_match: Callable[[Sequence[str]], Sequence[bool]] = lambda names: [True] * len(names),
    ) -> Page[ItemT]:
        """Return the entries after `cursor` that match, at most `limit`, the newest first.

        `filters` says which match; cursors of pages with other filters are refused.

        `fetch` returns several records, None for each that has expired or cannot be read. Those are
        skipped; those that have expired are removed from the listing. Entries that do not match
        according to `may_match`, which needs not read them, are not fetched. After `MOST_SKIPPED`
        skipped entries the page ends, with fewer entries or none, and its cursor continues behind
        them.
        """
        scope = f"{self.key} {filters}"
        last = None if cursor is None else _decode(cursor, scope)
        items: list[ItemT] = []
        skipped = 0
        while len(items) < limit and skipped < MOST_SKIPPED:
            # The more were in vain, the more are read at once.
            wanted = limit - len(items)
            count = min(max(wanted, skipped), wanted + MOST_SKIPPED - skipped)
            entries = self._entries(last, count)
            if not entries:
                return Page(tuple(items), None)
            names = [member for member, _ in entries]
            fitting = [one for one, fits in zip(names, may_match(names), strict=True) if fits]
            fetched, left = fitting[:wanted], fitting[wanted:]
            found = dict(zip(fetched, fetch(fetched), strict=True)) if fetched else {}
            for member, score in entries:
                if len(items) == limit or skipped == MOST_SKIPPED or member in left[:1]:
                    break
                last = (score, member)
                item = found.get(member)
                if member in found and item is None:
                    self.unlist(member, self.client)
                if item is not None and matches(item):
                    items.append(item)
                else:
                    skipped += 1
        more = last if last and self._entries(last, 1) else None
        return Page(tuple(items), None if more is None else _encode(more, scope))

    def unlist(self, member: str, client: Redis) -> None:
        """Remove an entry, unless there is a record of it."""
        # A shape may have been uploaded again since its record was read.
        scripts.UNLIST(client, [self.key, self.record(member)], member)

    def _entries(self, last: tuple[float, str] | None, count: int) -> list[tuple[str, float]]:
        start = math.inf if last is None else last[0]
        skip = 0
        entries: list[tuple[str, float]] = []
        # Entries of the same time are ordered by id; those up to the cursor are skipped over.
        while len(entries) < count:
            further = self.client.zrevrangebyscore(
                self.key, start, -math.inf, start=skip, num=count + 1, withscores=True
            )
            found = cast(list[tuple[bytes, float]], further)
            for member, score in found:
                if last is None or (score, text(member)) < last:
                    entries.append((text(member), score))
            if len(found) <= count:
                break
            skip += len(found)
        return entries[:count]


def sweep(client: Redis, listings: Sequence[Listing], cursor: int) -> tuple[int, int]:
    """Remove entries whose record has expired from a part of each of some listings.

    Parameters
    ----------
    client
        Connection to Redis.
    listings
        At least one.
    cursor
        In the first of them: 0 to begin, or the result of the step before. Others are begun.

    Returns
    -------
    How many of the first are done, and the cursor in the next one.
    """
    with client.pipeline(transaction=False) as pipe:
        for number, listing in enumerate(listings):
            pipe.zscan(listing.key, 0 if number else cursor, count=SWEEP_COUNT)
        replies = cast(list[tuple[int, list[tuple[bytes, float]]]], pipe.execute())
    done = next((number for number, (left, _) in enumerate(replies) if left), len(replies))
    parts = zip(listings, replies[: done + 1], strict=False)
    entries = [(listing, text(member)) for listing, (_, found) in parts for member, _ in found]
    with client.pipeline(transaction=False) as pipe:
        for listing, member in entries:
            pipe.exists(listing.record(member))
        found_records = pipe.execute()
    with client.pipeline(transaction=False) as pipe:
        for (listing, member), exists in zip(entries, found_records, strict=True):
            if not exists:
                listing.unlist(member, pipe)
        pipe.execute()
    return done, replies[done][0] if done < len(replies) else 0


def _encode(last: tuple[float, str], scope: str) -> str:
    place = f"{last[0]!r}:{last[1]}"
    told = f"{_checksum(place, scope)}:{place}"
    return base64.urlsafe_b64encode(told.encode()).decode().rstrip("=")


def _decode(cursor: str, scope: str) -> tuple[float, str]:
    try:
        told = base64.urlsafe_b64decode(cursor + "=" * (-len(cursor) % 4)).decode()
        checksum, place = told.split(":", 1)
        score, member = place.split(":", 1)
        last = (float(score), member)
    except (ValueError, binascii.Error) as error:
        raise InvalidCursor(_NO_PAGE) from error
    if checksum != _checksum(place, scope):
        raise InvalidCursor(_NO_PAGE)
    return last


def _checksum(place: str, scope: str) -> str:
    """Return what tells a cursor of this listing from others, and from invented ones."""
    return blake2b(f"{scope}:{place}".encode(), digest_size=8).hexdigest()
