"""Maps between all shapes of a collection, matched in pairs and improved by one another."""

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import Final

from broker.contracts import ConsistentMapsPayload, MatchParameters
from broker.store import Store
from solver.control import Control
from solver.errors import SolverError
from solver.shape import Shape
from worker.jobs.consistent_map_results import Collection, Pair, PairwiseMap, consistent_maps_of
from worker.jobs.context import JobContext, JobResult
from worker.jobs.failures import SHAPE_FAILURES, TimeUp, attributed_to, none_usable, reason_of
from worker.jobs.matches import load_shape
from worker.jobs.progress import SHARE_FOR_PARTS, TOTAL
from worker.jobs.registration_warnings import own_warnings
from worker.jobs.shape_names import shape_names
from worker.jobs.surface_matches import TIME_UP, match_surfaces

_LOADED: Final = 0.1
_MATCHED: Final = 0.9
"""Shares of the progress until all spectra are known, and until all pairs are matched."""

_TIME_OF_ALL: Final = 0.9
"""Share of the job's time after which no map is improved any more."""


def map_consistently(payload: ConsistentMapsPayload, context: JobContext) -> JobResult:
    """Match all pairs, and improve their maps by one another.

    A shape or a pair that cannot be matched is reported with the reason, and does not end the job.

    Raises
    ------
    ShapeGone, UnusableShape
        Too few shapes are left: some were deleted, or cannot be matched.
    TimeUp
        Before a pair was matched.
    SolverError
        No pair can be matched for another reason.
    Cancelled
        Through the reporter.
    """
    start, store = time.perf_counter(), context.store
    names = shape_names(payload.shapes, payload.names, store)
    seconds = context.queue.settings.job_timeout
    limit = context.reporter.control(_LOADED, _MATCHED).within(SHARE_FOR_PARTS * seconds)
    last = context.reporter.control(_MATCHED).within(_TIME_OF_ALL * seconds)
    shapes = _shapes(payload, context)
    loaded = time.perf_counter()
    collection = Collection(shapes, _matched(payload, shapes, limit))
    if not collection.maps:
        raise _failure(payload, collection, store)
    matched = time.perf_counter()
    last.report("consistency", 0.0)
    result, arrays = consistent_maps_of(payload, names, collection, last)
    ended = time.perf_counter()
    timings = {
        "spectra": loaded - start,
        "pairs": matched - loaded,
        "consistency": ended - matched,
        TOTAL: ended - start,
    }
    added = {"job": context.record.id, "timings": timings}
    document = result.model_copy(update=added).model_dump_json().encode()
    return JobResult(document, arrays)


def _shapes(payload: ConsistentMapsPayload, context: JobContext) -> list[Shape | str]:
    count = len(payload.shapes)
    found: list[Shape | str] = []
    for place, shape in enumerate(payload.shapes):
        share = _LOADED / count
        control = context.reporter.control(place * share, (place + 1) * share)
        control.report(f"spectrum {place + 1} of {count}", 0.0)
        field = f"shapes.{place}"
        try:
            loaded = load_shape(field, shape, payload, context, control)
            with attributed_to(field):
                found.append(loaded.shape(payload.parameters))
        except SHAPE_FAILURES as error:
            found.append(reason_of(error))
    return found


def _matched(
    payload: ConsistentMapsPayload, shapes: Sequence[Shape | str], control: Control
) -> dict[Pair, PairwiseMap | str]:
    """Match all pairs of usable shapes until the deadline."""
    pairs = list(combinations(range(len(shapes)), 2))
    found: dict[Pair, PairwiseMap | str] = {}
    for place, (i, j) in enumerate(pairs):
        source, target = shapes[i], shapes[j]
        if isinstance(source, str) or isinstance(target, str):
            found[i, j] = "one of its shapes cannot be matched"
        else:
            part = _part(control, place, len(pairs))
            part.report("", 0.0)
            found[i, j] = _map_of(source, target, payload.parameters, part)
    return found


def _part(control: Control, place: int, count: int) -> Control:
    """Return the control of one pair, whose stages are all reported as that pair."""

    def report(_: str, fraction: float) -> None:
        control.on_progress(f"pair {place + 1} of {count}", (place + fraction) / count)

    return replace(control, on_progress=report, timings={})


def _map_of(
    source: Shape, target: Shape, parameters: MatchParameters, control: Control
) -> PairwiseMap | str:
    found = match_surfaces(source, target, parameters, control)
    if isinstance(found, str):
        return found
    assert found.dense is not None
    assert found.confidence is not None
    warnings = own_warnings(found, source.mesh, target.mesh)
    return PairwiseMap(found.dense, found.confidence, warnings)


def _failure(payload: ConsistentMapsPayload, collection: Collection, store: Store) -> Exception:
    """Return why no pair could be matched: because of its shapes, of the time, or of its maps."""
    unusable = [one if isinstance(one, str) else None for one in collection.shapes]
    reasons = [
        str(reason)
        for (i, j), reason in collection.pairs.items()
        if unusable[i] is None and unusable[j] is None
    ]
    if not reasons:
        return none_usable(payload.shapes, unusable, store)
    if TIME_UP in reasons:
        return TimeUp(TIME_UP)
    return SolverError(f"No pair of shapes could be matched; of the first, {reasons[0]}.")
