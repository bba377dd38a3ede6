"""Overhead of the service over the solver in a comparison: ``python -m bench.service``.

The service, started as a user starts it, compares all pairs of the shapes, from the request to the
result in the client's hands; beside it, as many bare processes as the service has workers do the
same with nothing around them. Spectra are known to both, signatures are not: each round asks for a
metric that nobody has asked for. A second table has pairs a second on one core, signatures known; a
third, what a large collection takes, of signatures that are made up.
"""

import gzip
import os
import resource
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from isomatch import Client
from isomatch import Shape as Uploaded

from bench.collection import KnownShape, collection, require
from bench.command_line import command_line, parsed, print_json
from broker.contracts import (
    DissimilaritiesPayload,
    DissimilarityParameters,
    ShapeRecord,
    spectrum_key,
)
from broker.queue import JobQueue
from broker.store import DEFAULT_KEYS, Store
from demo.stack import running_stack
from service.standalone import EmbeddedServer, WorkerPool
from solver.shape import Shape
from solver.shape.choices import Diffusion
from solver.similarity import (
    SAMPLINGS,
    Signature,
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    number_of_pairs,
    pairs_between,
    signature,
)
from worker.settings import WorkerSettings

_ROUNDS = 3
"""Times that each side is measured."""

_shapes: list[Shape] = []
"""What the bare processes inherit."""


def cores() -> int:
    """Return how many cores there are for this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def options_of(round_number: int, points: int = 6) -> SimilarityOptions:
    """Return options that no other round has: another time of the diffusion metric."""
    return SimilarityOptions(points, Diffusion(time=0.01 + 1e-6 * round_number))


def bare_seconds(pool: ProcessPoolExecutor, options: SimilarityOptions) -> float:
    """Wall time of the bare processes for all signatures and pairs."""
    started = time.perf_counter()
    places = range(len(_shapes))
    found = list(pool.map(_signature, places, [options] * len(_shapes)))
    collection = SignatureCollection.of(found, options.points)
    dissimilarities(collection, pairs_between(len(found), 0, number_of_pairs(len(found))), options)
    return time.perf_counter() - started


def _signature(place: int, options: SimilarityOptions) -> Signature:
    known = _shapes[place]
    # Nothing but the spectrum is known.
    return signature(Shape(known.mesh, known.spectrum()), options)


def service_seconds(
    client: Client, shapes: Sequence[Uploaded], options: SimilarityOptions
) -> tuple[float, np.ndarray]:
    """Wall time of the service from the request to the result, and the matrix."""
    assert isinstance(options.metric, Diffusion)
    metric = {"name": "diffusion", "time": options.metric.time}
    started = time.perf_counter()
    found = client.dissimilarities(shapes, points=options.points, metric=metric).result()
    return time.perf_counter() - started, found.matrix


def compare_with_service(known: list[KnownShape]) -> tuple[float, float]:
    """Median seconds of the service and of the bare processes, in turns."""
    times = []
    with running_stack({"ISOMATCH_LOG_LEVEL": "WARNING"}) as stack, Client(stack.url) as client:
        uploaded = [client.upload((one.shape.mesh.vertices, one.shape.mesh.faces)) for one in known]
        _shapes[:] = [one.shape for one in known]
        for shape in _shapes:
            shape.spectrum()
        with ProcessPoolExecutor(cores()) as pool:
            service_seconds(client, uploaded, options_of(0))
            bare_seconds(pool, options_of(0))
            for number in range(1, _ROUNDS + 1):
                options = options_of(number)
                served, _ = service_seconds(client, uploaded, options)
                times.append((served, bare_seconds(pool, options)))
            again, _ = service_seconds(client, uploaded, options_of(_ROUNDS))
    served, bare = np.median(np.array(times), axis=0)
    print(
        f"{len(known)} shapes, {number_of_pairs(len(known))} pairs, {cores()} cores, spectra known"
    )
    print(f"{'service':32}{served:9.3f} s")
    print(f"{'bare processes':32}{bare:9.3f} s")
    print(f"{'service, signatures known too':32}{again:9.3f} s")
    print(f"{'service / bare':32}{served / bare:9.2f}")
    return float(served), float(bare)


def pairs_a_second(known: list[KnownShape]) -> dict[str, float]:
    """Pairs compared in a second on one core, signatures known, by points and objective."""
    found = [signature(one.shape, SimilarityOptions()) for one in known]
    pairs = pairs_between(len(found), 0, number_of_pairs(len(found)))
    figures = {}
    print(f"\n{'pairs a second and core':32}{'points':>8}{'l2':>10}{'linf':>10}")
    for points in (6, 8, 10):
        row = []
        for objective in ("l2", "linf"):
            options = SimilarityOptions(points, objective=objective)
            collection = SignatureCollection.of(found, points)
            dissimilarities(collection, pairs[:1], options)
            seconds = []
            for _ in range(3):
                started = time.process_time()
                dissimilarities(collection, pairs, options)
                seconds.append(time.process_time() - started)
            row.append(len(pairs) / min(seconds))
        figures[f"pairs_per_second_{points}"] = row[0]
        print(f"{'':32}{points:8}{row[0]:10.0f}{row[1]:10.0f}")
    return figures


def made_up(
    store: Store, count: int, parameters: DissimilarityParameters
) -> DissimilaritiesPayload:
    """Shapes that are known by their signatures alone, which are random metrics."""
    random = np.random.default_rng(0)
    shapes = tuple(f"made-up-{place}" for place in range(count))
    for shape in shapes:
        record = ShapeRecord(
            id=shape, name=shape, file_type="off", bytes=1, vertices=10, faces=10, area=1.0,
            components=1, closed=True, has_colors=False, warnings=(), created=datetime.now(UTC),
        )  # fmt: skip
        store.client.set(DEFAULT_KEYS.shape(shape), record.model_dump_json())
        points = random.standard_normal((len(SAMPLINGS), 10, int(random.integers(2, 6))))
        distances = np.linalg.norm(points[:, :, None] - points[:, None], axis=3)
        indices = np.zeros(distances.shape[:2], dtype=np.int64)
        found = Signature(indices, distances, np.zeros((*indices.shape, 0)))
        name = parameters.signature_name(spectrum_key(parameters, record))
        store.spectra.put(name, found.to_bytes())
    labels = tuple(str(place % 20) for place in range(count))
    return DissimilaritiesPayload(shapes=shapes, labels=labels, parameters=parameters)


@contextmanager
def workers() -> Iterator[JobQueue]:
    """A store and a worker for each core."""
    with tempfile.TemporaryDirectory(prefix="isomatch-") as directory:
        server = EmbeddedServer(Path(directory))
        server.start()
        blobs = Path(directory, "blobs").as_uri()
        settings = WorkerSettings(redis_url=server.url, blob_url=blobs)
        queue = JobQueue(Store.open(settings, retry_seconds=10), settings)
        os.environ["ISOMATCH_LOG_LEVEL"] = "WARNING"
        pool = WorkerPool(cores(), server.url, blobs)
        pool.start()
        try:
            while queue.workers() < cores():
                time.sleep(0.1)
            yield queue
        finally:
            pool.stop()
            queue.store.close()
            server.stop()


def compare_many(count: int) -> float:
    """Seconds that the workers take for a large collection, signatures known."""
    with workers() as queue:
        payload = made_up(queue.store, count, DissimilarityParameters())
        started = time.perf_counter()
        job = queue.submit(payload)
        while (record := queue.store.jobs.get(job.id)) is not None and not record.state.ended:
            time.sleep(0.05)
        seconds = time.perf_counter() - started
        packed, arrays = queue.store.results.document(job.id), queue.store.results.arrays(job.id)
        assert packed is not None
        assert arrays is not None
        plain = len(gzip.decompress(packed))
    megabytes = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"\n{count} made-up shapes, {number_of_pairs(count)} pairs, {cores()} cores")
    print(f"{'from request to result':32}{seconds:9.1f} s")
    print(f"{'result, gzip / plain / arrays':32}", end="")
    print(" / ".join(f"{size / 1e6:.1f}" for size in (len(packed), plain, len(arrays))), "MB")
    print(f"{'most memory of a process':32}{megabytes:9.0f} MB")
    return seconds


def main() -> None:
    """Measure, print the tables."""
    parser = command_line(__doc__, data=True)
    parser.add_argument("--many", type=int, default=1000, help="made-up shapes; 0 for none")
    arguments = parsed(parser)
    known = collection(arguments.data, 5000, 6)
    require(parser, known[1:])
    served, bare = compare_with_service(known)
    figures = {
        "service_seconds": served,
        "solver_seconds": bare,
        "service_over_solver": served / bare,
        **pairs_a_second(known),
    }
    if arguments.many:
        figures["many_seconds"] = compare_many(arguments.many)
    print_json(arguments, figures)


if __name__ == "__main__":
    main()
