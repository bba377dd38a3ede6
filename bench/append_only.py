"""What a server that is killed knows afterwards."""

import time

from redis import Redis


def until_written(url: str) -> None:
    """Wait until all that a server has acknowledged so far is in its append-only file.

    It answers before its file is on the disk; and where a disk is busy, before it has written at
    all, which a server that is killed just then never does.
    """
    deadline = time.monotonic() + 60.0
    with Redis.from_url(url) as client:
        while client.info("persistence")["aof_buffer_length"]:
            assert time.monotonic() < deadline
            time.sleep(0.005)
