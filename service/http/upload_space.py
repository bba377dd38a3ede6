"""Space for the bodies of uploads on their way, which are in temporary files."""

import asyncio


class UploadSpace:
    """Bytes that the bodies of all uploads on their way may take together.

    Requests wait for space in the order in which they came.

    Parameters
    ----------
    size
        Number of bytes.
    """

    def __init__(self, size: int) -> None:
        self._free = size
        self._turn = asyncio.Lock()
        self._freed = asyncio.Event()

    async def take(self, size: int) -> None:
        """Wait until some bytes are free, and take them."""
        async with self._turn:
            while self._free < size:
                self._freed.clear()
                await self._freed.wait()
            self._free -= size

    def give_back(self, size: int) -> None:
        """Free bytes that were taken."""
        self._free += size
        self._freed.set()
