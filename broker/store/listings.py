"""Listings in pages: newest first, with a cursor that stays right while entries come and go."""

import base64
import binascii
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Generic, TypeVar, cast

from redis import Redis

from broker.store import scripts
from broker.store.records import NewerRecord
from broker.store.replies import text

ItemT = TypeVar("ItemT")

SWEPT_AT_ONCE: Final = 500

MOST_PASSED: Final = 1000
"""Entries that a page passes over, each of which has to be looked at."""


class InvalidCursor(ValueError):  # noqa: N818 - said of the cursor
    """A cursor that no page gave."""


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
        fetch: Callable[[str], ItemT | None],
        suits: Callable[[ItemT], bool] = lambda item: True,
    ) -> Page[ItemT]:
        """Return the entries after `cursor` that suit, at most `limit`, the newest first.

        Entries whose record has expired are passed over and taken out of the listing, those of
        newer versions that cannot be read are only passed over. No more than
        `MOST_PASSED` are passed over: then there are fewer on the page, if any, and its cursor goes
        on behind them.
        """
        last = None if cursor is None else _decode(cursor)
        items: list[ItemT] = []
        passed = 0
        while len(items) < limit and passed < MOST_PASSED:
            entries = self._entries(last, limit - len(items))
            if not entries:
                return Page(tuple(items), None)
            for member, score in entries:
                last = (score, member)
                try:
                    item = fetch(member)
                except NewerRecord:
                    passed += 1
                    continue
                if item is None:
                    self._unlist(member, self.client)
                if item is not None and suits(item):
                    items.append(item)
                else:
                    passed += 1
        return Page(tuple(items), _encode(last) if last and self._entries(last, 1) else None)

    def sweep(self, cursor: int) -> int:
        """Take entries whose record has expired out of one part of the listing.

        Parameters
        ----------
        cursor
            Where to go on; 0 to begin.

        Returns
        -------
        int
            Where to go on next time; 0 at the end.
        """
        reply = self.client.zscan(self.key, cursor, count=SWEPT_AT_ONCE)
        cursor, found = cast(tuple[int, list[tuple[bytes, float]]], reply)
        members = [text(member) for member, _ in found]
        with self.client.pipeline(transaction=False) as pipe:
            for member in members:
                pipe.exists(self.record(member))
            there = pipe.execute()
        with self.client.pipeline(transaction=False) as pipe:
            for member, exists in zip(members, there, strict=True):
                if not exists:
                    self._unlist(member, pipe)
            pipe.execute()
        return cursor

    def _unlist(self, member: str, client: Redis) -> None:
        # A shape may have been uploaded again since its record was looked for.
        client.eval(scripts.UNLIST, 2, self.key, self.record(member), member)

    def _entries(self, last: tuple[float, str] | None, count: int) -> list[tuple[str, float]]:
        start = math.inf if last is None else last[0]
        skip = 0
        entries: list[tuple[str, float]] = []
        # Entries of the same time are ordered by id; those up to the cursor are passed over.
        while len(entries) < count:
            found: list[tuple[bytes, float]] = self.client.zrevrangebyscore(  # type: ignore[assignment]
                self.key, start, -math.inf, start=skip, num=count + 1, withscores=True
            )
            for member, score in found:
                if last is None or (score, text(member)) < last:
                    entries.append((text(member), score))
            if len(found) <= count:
                break
            skip += len(found)
        return entries[:count]


def _encode(last: tuple[float, str]) -> str:
    return base64.urlsafe_b64encode(f"{last[0]!r}:{last[1]}".encode()).decode().rstrip("=")


def _decode(cursor: str) -> tuple[float, str]:
    try:
        text = base64.urlsafe_b64decode(cursor + "=" * (-len(cursor) % 4)).decode()
        score, member = text.split(":", 1)
        last = (float(score), member)
    except (ValueError, binascii.Error) as error:
        raise InvalidCursor("this is not a cursor that a page gave") from error
    if not math.isfinite(last[0]):
        raise InvalidCursor("this is not a cursor that a page gave")
    return last
