"""Listings in pages, newest first; a cursor stays valid while entries come and go."""

import base64
import binascii
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from itertools import accumulate
from typing import Final, Generic, TypeVar, cast

from redis import Redis

from broker.store import scripts
from broker.store.replies import text

ItemT = TypeVar("ItemT")

SWEEP_COUNT: Final = 20_000
"""Entries that one step of a sweep looks at."""

_AT_A_TIME: Final = 500
"""Entries for which Redis waits, about a millisecond."""

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
                    self.unlist([member], self.client)
                if item is not None and matches(item):
                    items.append(item)
                else:
                    skipped += 1
        more = last if last and self._entries(last, 1) else None
        return Page(tuple(items), None if more is None else _encode(more, scope))

    def unlist(self, members: Sequence[str], client: Redis) -> None:
        """Remove those of these entries of which there is no record."""
        # A shape may have been uploaded again since its record was read.
        scripts.UNLIST(client, [self.key, *map(self.record, members)], *members)

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


def sweep(client: Redis, listings: Sequence[Listing], start: int) -> tuple[int, int]:
    """Remove entries whose record has expired from the next `SWEEP_COUNT` entries of some listings.

    Parameters
    ----------
    client
        Connection to Redis.
    listings
        At least one.
    start
        Rank of the next entry in the first of them: 0 to begin, or the result of the step before.
        An entry that is passed over, because others changed the ranks, is seen in the next round.

    Returns
    -------
    How many of the listings are done, and the rank of the next entry in the one after them.
    """
    with client.pipeline(transaction=False) as pipe:
        for listing in listings:
            pipe.zcard(listing.key)
        counts = cast(list[int], pipe.execute())
        start = min(start, counts[0])
        stop = start + SWEEP_COUNT
        # As if they were one listing: where each of them begins, and the last one ends.
        begins = list(accumulate(counts, initial=0))
        ranges = zip(listings, counts, begins, strict=False)
        swept = [(one, begin) for one, count, begin in ranges if count and begin < stop]
        for listing, begin in swept:
            pipe.zrange(listing.key, max(start - begin, 0), stop - begin - 1)
        found = cast(list[list[bytes]], pipe.execute())
        parts = [
            (listing, [text(member) for member in members[first : first + _AT_A_TIME]])
            for (listing, _), members in zip(swept, found, strict=True)
            for first in range(0, len(members), _AT_A_TIME)
        ]
        for listing, members in parts:
            listing.unlist(members, pipe)
        removed = cast(list[int], pipe.execute())
    done = sum(end <= stop for end in begins[1:])
    if done == len(listings):
        return done, 0
    gone = sum(n for (one, _), n in zip(parts, removed, strict=True) if one is listings[done])
    return done, stop - begins[done] - gone


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
