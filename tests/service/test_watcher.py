"""Many requests that wait are served by one reading at a time."""

import asyncio
import threading
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress

import pytest

from service.watcher import Watcher


class Values:
    """Values that are read, and the keys of each reading."""

    def __init__(self, **values: int) -> None:
        self.values = values
        self.readings: list[Sequence[str]] = []
        self.error: Exception | None = None

    def read(self, keys: Sequence[str]) -> list[int]:
        self.readings.append(sorted(keys))
        if self.error is not None:
            raise self.error
        return [self.values[key] for key in keys]


@asynccontextmanager
async def running(read: Callable[[Sequence[str]], list[int]]) -> AsyncIterator[Watcher[str, int]]:
    watcher = Watcher(read)
    task = asyncio.create_task(watcher.run())
    try:
        yield watcher
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


def test_those_who_wait_share_the_readings_and_are_told_of_changes() -> None:
    values = Values(a=0, b=1)

    async def run() -> None:
        async with running(values.read) as watcher:
            with (
                watcher.change("a", 0) as first,
                watcher.change("a", 0) as second,
                watcher.change("b", 0) as other,
            ):
                assert await other == 1
                assert not first.done()
                values.values["a"] = 2
                assert await first == await second == 2
            assert values.readings[0] == ["a", "b"]

    asyncio.run(run())


def test_an_error_is_that_of_all_who_wait_and_the_next_reading_is_another() -> None:
    values = Values(a=1)
    values.error = OSError("away")

    async def run() -> None:
        async with running(values.read) as watcher:
            with watcher.change("a", 0) as first, watcher.change("a", 0) as second:
                for change in (first, second):
                    with pytest.raises(OSError, match="away"):
                        await change
            values.error = None
            with watcher.change("a", 0) as change:
                assert await change == 1

    asyncio.run(run())


def test_nothing_is_left_of_those_who_are_cancelled() -> None:
    values = Values(a=0, b=0, c=1)

    async def wait(watcher: Watcher[str, int], key: str) -> None:
        with watcher.change(key, 0) as change:
            await change

    async def run() -> None:
        async with running(values.read) as watcher:
            waiting = [asyncio.create_task(wait(watcher, key)) for key in ("a", "b")]
            await wait(watcher, "c")
            for task in waiting:
                task.cancel()
            await asyncio.wait(waiting)
            values.readings.clear()
            await wait(watcher, "c")
            assert values.readings == [["c"]]

    asyncio.run(run())


def test_who_joins_during_a_reading_is_not_told_what_was_read_before() -> None:
    begun, go_on, values = threading.Event(), threading.Event(), Values(a=1)

    def read(keys: Sequence[str]) -> list[int]:
        found = values.read(keys)
        if len(values.readings) == 1:
            begun.set()
            go_on.wait()
        return found

    async def run() -> None:
        async with running(read) as watcher:
            with watcher.change("a", 0) as first:
                await asyncio.to_thread(begun.wait)
                values.values["a"] = 2
                # This one has seen the new value already.
                with watcher.change("a", 2) as second:
                    go_on.set()
                    assert await first == 1
                    assert not second.done()
                    values.values["a"] = 3
                    assert await second == 3

    asyncio.run(run())


def test_all_are_cancelled_when_the_server_stops() -> None:
    async def run() -> None:
        async with running(Values(a=0).read) as watcher:
            with watcher.change("a", 0) as before:
                watcher.close()
                assert before.cancelled()
            with watcher.change("a", 0) as after:
                assert after.cancelled()

    asyncio.run(run())
