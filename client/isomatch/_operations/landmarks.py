"""Operations that carry landmarks of templates to a specimen."""

from collections.abc import Callable, MutableMapping, Sequence
from contextlib import suppress
from typing import Final, TypeAlias, cast
from uuid import uuid4

import numpy as np

from isomatch._errors import ConnectionFailed, JobFailed, WrongCoordinates
from isomatch._http import Operation, wait_given
from isomatch._landmarks import (
    CarriedLandmarks,
    FromTemplate,
    LandmarkSet,
    LandmarkTemplate,
    from_transfer,
    merged,
    missing_landmarks,
    same_order,
)
from isomatch._models import JobRecord, MatchParameters, Shape
from isomatch._operations.jobs import cancel_job, start_match, wait_for_job, watch_job
from isomatch._operations.request_parts import listed
from isomatch._operations.results import check_succeeded, get_document
from isomatch._operations.shapes import get_geometry
from isomatch._operations.transfers import start_transfer
from isomatch._results import Transfer

FIXED: Final = ("dense", "simplify", "landmarks", "occlusion_cost", "refine")
"""Parameters of matches that carrying landmarks sets itself, or that it has no use for."""

MISPLACED: Final = "urn:isomatch:problem:misplaced-landmarks"
"""Problem of landmarks in another unit of length or coordinate system than their mesh."""

Transfers: TypeAlias = MutableMapping[str, str]
"""Ids of transfers by those of their matches."""

Wait: TypeAlias = Callable[[str, float | None, Callable[[JobRecord], None]], Operation[None]]
"""A way to wait for a job."""


def start_landmarks(
    templates: Sequence[LandmarkTemplate],
    specimen: Shape | str,
    parameters: MatchParameters,
    keys: list[str],
) -> Operation[list[JobRecord]]:
    """Queue a dense match of each template with a specimen.

    Parameters
    ----------
    templates, specimen
        What is matched.
    parameters
        Of the matches.
    keys
        Takes the idempotency key of each match before it is sent, for :func:`withdraw_landmarks`,
        without those that did not reach the service.

    Raises
    ------
    TypeError, ValueError
        There is no template, or a parameter is given that is not taken.
    """
    if not listed(templates, "templates"):
        raise ValueError("give at least one template")
    given = [name for name in FIXED if name in parameters]
    if given:
        raise TypeError(f"landmarks() takes no parameter {given[0]!r}")
    started = []
    for one in templates:
        keys.append(uuid4().hex)
        try:
            started.append((yield from _start(one, specimen, parameters, keys[-1])))
        except ConnectionFailed as error:
            if not error.sent:
                keys.pop()
            raise
    return started


def withdraw_landmarks(
    templates: Sequence[LandmarkTemplate],
    specimen: Shape | str,
    parameters: MatchParameters,
    keys: Sequence[str],
) -> Operation[None]:
    """Cancel the matches that :func:`start_landmarks`, with the same arguments, has queued.

    The answer to the last one may have been lost: each is asked for again by its idempotency key.
    """
    for place, key in enumerate(keys):
        # What the service or a check refused at first is refused again.
        with suppress(Exception):
            record = yield from _start(templates[place], specimen, parameters, key)
            yield from cancel_job(record.id)


def _start(
    template: LandmarkTemplate, specimen: Shape | str, parameters: MatchParameters, key: str
) -> Operation[JobRecord]:
    dense: MatchParameters = {**parameters, "dense": True}
    return (
        yield from start_match(template.shape, specimen, parameters=dense, webhook=None, key=key)
    )


def get_landmarks(
    templates: Sequence[LandmarkTemplate],
    specimen: Shape | str,
    job_ids: Sequence[str],
    transfers: Transfers,
    progress: bool,
    timeout: float | None,
) -> Operation[CarriedLandmarks]:
    """Wait for the matches of templates with a specimen, and carry the landmarks.

    Parameters
    ----------
    templates, specimen
        As for :func:`start_landmarks`.
    job_ids
        Of the matches.
    transfers
        Those that were started before, which are taken up; takes the others.
    progress
        Show a progress bar for each match, and for each transfer.
    timeout
        Seconds to wait for each match, and for each transfer; None for no limit.
    """
    limit = wait_given(timeout)
    orders = same_order([one.landmarks for one in templates])
    wait = watch_job if progress else wait_for_job
    probabilities = []
    for template, job_id in zip(templates, job_ids, strict=True):
        match = yield from _ended(wait, job_id, limit)
        if match.summary is None or match.summary.confidence is None:
            raise ValueError("landmarks are carried along dense matches with a confidence")
        probabilities.append(match.summary.confidence.probability)
        if job_id not in transfers and template.landmarks.present.any():
            transfers[job_id] = (yield from _start_transfer(job_id, template.landmarks)).id
    each = []
    for template, order, job_id in zip(templates, orders, job_ids, strict=True):
        found = missing_landmarks(len(template.landmarks))
        if job_id in transfers:
            found = yield from _transferred(wait, transfers[job_id], limit)
        each.append(found.at(order))
    surface = (yield from get_geometry(specimen)) if len(templates) > 1 else None
    return merged(templates[0].landmarks.labels, each, np.array(probabilities), surface)


def _start_transfer(match: str, landmarks: LandmarkSet) -> Operation[JobRecord]:
    return (
        yield from start_transfer(
            match,
            None,
            what="landmarks",
            direction="source_to_target",
            on=None,
            names=(),
            influences=None,
            points=(),
            landmarks=landmarks,
            webhook=None,
            key=None,
        )
    )


def _transferred(wait: Wait, job_id: str, limit: float | None) -> Operation[FromTemplate]:
    """Wait for a transfer, and return the landmarks of the specimen."""
    try:
        record = yield from _ended(wait, job_id, limit)
    except JobFailed as error:
        if error.problem is None or error.problem.type != MISPLACED:
            raise
        raise WrongCoordinates(error.problem.summary) from error
    found = cast(Transfer, (yield from get_document(record)))
    assert found.landmarks is not None
    return from_transfer(found.landmarks)


def _ended(wait: Wait, job_id: str, limit: float | None) -> Operation[JobRecord]:
    records: list[JobRecord] = []
    yield from wait(job_id, limit, records.append)
    check_succeeded(records[-1])
    return records[-1]


def cancel_landmarks(job_ids: Sequence[str]) -> Operation[None]:
    """Cancel the matches and transfers that have not ended."""
    for job_id in job_ids:
        yield from cancel_job(job_id)
