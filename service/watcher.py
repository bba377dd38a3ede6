"""One task that reads what many requests wait for, all of it in one go."""

import asyncio
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Final, Generic, TypeVar

from starlette.concurrency import run_in_threadpool

FIRST_PAUSE: Final = 0.01
"""Seconds between two readings after a request has begun to wait."""

LONGEST_PAUSE: Final = 0.25
"""Seconds that pauses grow to, by half each time."""

_IDLE: Final = 9.0
"""Least pause, as a multiple of the time that reading took: it takes a tenth of a core at most."""

_LONGEST_IDLE: Final = 1.0
"""Seconds; a reading that took long, such as one that failed, is repeated after them."""

KeyT = TypeVar("KeyT")
ValueT = TypeVar("ValueT")


@dataclass(frozen=True, eq=False)
class _Waiter(Generic[KeyT, ValueT]):
    key: KeyT
    last: ValueT
    change: asyncio.Future[ValueT]


@dataclass(eq=False)
class Watcher(Generic[KeyT, ValueT]):
    """Values of a store that requests wait for.

    It polls: what it reads is right after a restart of the store, whichever process changed it.

    Parameters
    ----------
    read
        Returns the values of several keys. It runs in a thread, one call at a time.
    """

    read: Callable[[Sequence[KeyT]], Sequence[ValueT]]
    _waiters: set[_Waiter[KeyT, ValueT]] = field(default_factory=set, init=False)
    _joined: asyncio.Event = field(default_factory=asyncio.Event, init=False)
    _closed: bool = field(default=False, init=False)

    @contextmanager
    def change(self, key: KeyT, last: ValueT) -> Iterator[asyncio.Future[ValueT]]:
        """Provide the next value of a key that differs from the last one.

        The future has the error of a reading that failed, and is cancelled when the server stops.
        """
        change: asyncio.Future[ValueT] = asyncio.get_running_loop().create_future()
        waiter = _Waiter(key, last, change)
        if self._closed:
            change.cancel()
        self._waiters.add(waiter)
        self._joined.set()
        try:
            yield change
        finally:
            self._waiters.discard(waiter)
            if not (change.cancel() or change.cancelled()):
                change.exception()  # otherwise it is logged as one that nobody has seen

    def close(self) -> None:
        """Cancel all futures, those to come, too."""
        self._closed = True
        for waiter in self._waiters:
            waiter.change.cancel()

    async def run(self) -> None:
        """Read what is waited for, again and again, until this task is cancelled."""
        least = FIRST_PAUSE
        while True:
            await self._joined.wait()
            self._joined.clear()
            pause = FIRST_PAUSE
            while self._waiters:
                await asyncio.sleep(least)
                with suppress(TimeoutError):
                    async with asyncio.timeout(pause - least):
                        await self._joined.wait()
                pause = FIRST_PAUSE if self._joined.is_set() else min(pause * 1.5, LONGEST_PAUSE)
                self._joined.clear()
                seconds = await self._read_all()
                least = min(max(FIRST_PAUSE, _IDLE * seconds), _LONGEST_IDLE)

    async def _read_all(self) -> float:
        """Read once; return the seconds it took."""
        clock = asyncio.get_running_loop().time
        began = clock()
        # Those who join meanwhile may know something newer than what is being read.
        waiters = tuple(self._waiters)
        keys = list({waiter.key for waiter in waiters})
        try:
            values = await run_in_threadpool(self.read, keys)
            found = dict(zip(keys, values, strict=True))
        except Exception as error:
            for waiter in waiters:
                if not waiter.change.done():
                    waiter.change.set_exception(error)
        else:
            for waiter in waiters:
                value = found[waiter.key]
                if value != waiter.last and not waiter.change.done():
                    waiter.change.set_result(value)
        return clock() - began
