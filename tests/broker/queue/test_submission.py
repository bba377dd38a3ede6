"""Jobs that several requests need at the same time: there is one of them."""

from concurrent.futures import ThreadPoolExecutor

from broker.contracts import JobKind, MatchParameters, MatchPayload, PicturePayload
from broker.queue import JobQueue
from tests.broker.store.records import accepted, numbered

THREADS = 16


def test_a_spectrum_is_queued_once(queue: JobQueue) -> None:
    pairs = [[accepted(queue.store, numbered(2 * n + k)).id for k in range(2)] for n in range(5)]
    with ThreadPoolExecutor(THREADS) as threads:
        for source, target in pairs:
            match = MatchPayload(source=source, target=target, parameters=MatchParameters())
            list(threads.map(queue.submit, [match] * THREADS))
    queued = [one for one in queue.store.jobs.active() if one.kind is JobKind.SPECTRUM]
    assert len(queued) == 2 * len(pairs)


def test_a_picture_is_drawn_once(queue: JobQueue) -> None:
    with ThreadPoolExecutor(THREADS) as threads:
        for drawn in range(5):
            asked = [PicturePayload(job=f"{drawn}")] * THREADS
            assert len(set(threads.map(queue.submit_picture, asked))) == 1
    assert queue.rq.waiting() == 5
