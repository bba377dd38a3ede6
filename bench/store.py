"""Memory of the queue's Redis with many shapes and results: ``python -m bench.store``.

Two generated figures are uploaded and matched by real workers. Everything that Redis then keeps of
the target and of the match is copied under the names of further shapes and jobs, and the growth of
``used_memory`` is measured. The spectrum cache, which has a budget of its own, is not copied.
"""

import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

from bench.command_line import command_line, parsed, print_json
from bench.service import workers
from broker.contracts import JobRecord, MatchParameters, MatchPayload, ValidationPayload, shape_id
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Store, text
from broker.telemetry import configure_logging
from demo.figures import generate, write_off
from synthetic import SyntheticShape

_IN_ONE_GO = 200
"""Shapes that are copied in one round trip."""


@dataclass(frozen=True)
class Known:
    """What is copied.

    Parameters
    ----------
    shape, job
        Ids of the shape and of its match.
    references
        Sizes in bytes of their blobs, by the keys of the references.
    others
        Their other keys, as they are in Redis.
    """

    shape: str
    job: str
    references: dict[str, int]
    others: tuple[str, ...]


def matched(queue: JobQueue, vertices: int, dense: bool) -> Known:
    """Upload two figures, match them, and return what is kept of the target and of the match."""
    figures = generate(vertices)
    names = [uploaded(queue, shape) for shape in (figures.source, figures.target)]
    parameters = MatchParameters(dense=dense)
    payload = MatchPayload(source=names[0], target=names[1], parameters=parameters)
    job = ended(queue, queue.submit(payload).id)
    return known(queue.store, names[1], job.id)


def uploaded(queue: JobQueue, shape: SyntheticShape) -> str:
    """Have a shape validated, and return its id."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "figure.off")
        write_off(path, shape)
        data = path.read_bytes()
    payload = ValidationPayload(shape=shape_id(data), name="figure", file_type="off")
    ended(queue, queue.submit_validation(payload, data))
    return shape_id(data)


def ended(queue: JobQueue, job: str) -> JobRecord:
    """Wait for the end of a job."""
    while (record := queue.store.jobs.get(job)) is None or not record.state.ended:
        time.sleep(0.05)
    assert record.error is None, record.error
    return record


def known(store: Store, shape: str, job: str) -> Known:
    """Return the keys of a shape and of a job."""
    found = {
        text(key)
        for prefix in (
            DEFAULT_KEYS.shape(shape),
            DEFAULT_KEYS.job(job),
            DEFAULT_KEYS.jobs_of(shape),
        )
        for key in store.client.scan_iter(f"{prefix}*", count=1000)
    }
    references = {}
    for key in sorted(found):
        if text(store.client.type(key)) == "hash" and store.client.hlen(key) == 1:
            data = store.blobs.get(key)
            assert data is not None
            references[key] = len(data)
    return Known(shape, job, references, tuple(sorted(found - set(references))))


def copied(store: Store, one: Known, count: int) -> float:
    """Copy what is known so many times; return the growth of Redis in bytes for each copy."""
    client = store.client
    before = used(store)
    made: list[str] = []
    for start in range(0, count, _IN_ONE_GO):
        with client.pipeline(transaction=False) as pipe:
            for _ in range(start, min(start + _IN_ONE_GO, count)):
                shape, job = shape_id(uuid4().bytes), uuid4().hex
                for key in (*one.references, *one.others):
                    name = key.replace(one.shape, shape).replace(one.job, job)
                    made.append(name)
                    pipe.copy(key, name)
                now = time.time()
                pipe.zadd(DEFAULT_KEYS.shapes, {shape: now})
                for listing in (DEFAULT_KEYS.jobs, DEFAULT_KEYS.jobs_in("succeeded")):
                    pipe.zadd(listing, {job: now})
            pipe.execute()
    grown = (used(store) - before) / count
    for part in parts(made, 10_000):
        client.delete(*part)
    return grown


def parts(names: list[str], size: int) -> Iterator[list[str]]:
    """Iterate over a list in parts."""
    for start in range(0, len(names), size):
        yield names[start : start + size]


def used(store: Store) -> int:
    """Return ``used_memory`` of Redis."""
    return int(store.client.info("memory")["used_memory"])


def main() -> None:
    """Measure, print the table."""
    parser = command_line(__doc__)
    parser.add_argument("--vertices", type=int, default=50_000, help="of a shape")
    parser.add_argument("--shapes", type=int, default=10_000, help="copies, each with a result")
    parser.add_argument("--sparse", action="store_true", help="matches without dense maps")
    arguments = parsed(parser)
    configure_logging("WARNING", process="bench")
    with workers() as queue:
        one = matched(queue, arguments.vertices, not arguments.sparse)
        each = copied(queue.store, one, arguments.shapes)
    for key, size in one.references.items():
        print(f"{key.split(':')[1]:8}{key.rpartition(':')[2]:16}{size / 1e6:10.3f} MB")
    blobs = sum(one.references.values())
    total = each * arguments.shapes / 1e6
    print(f"\n{arguments.shapes} shapes of {arguments.vertices} vertices, a match each:")
    print(f"{'in Redis, measured':40}{total:10.1f} MB, {each:.0f} bytes each")
    print(f"{'in the blob store':40}{blobs * arguments.shapes / 1e6:10.1f} MB")
    figures = {"megabytes": total, "bytes_each": each}
    print_json(arguments, {**figures, "blob_bytes_each": blobs})


if __name__ == "__main__":
    main()
