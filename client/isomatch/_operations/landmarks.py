"""Operations that carry landmarks of templates to a specimen."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Final, cast
from uuid import uuid4

from isomatch._errors import ConnectionFailed
from isomatch._http import Operation, wait_given
from isomatch._landmarks import (
    CarriedLandmarks,
    LandmarkTemplate,
    PlacedLandmarks,
    Placements,
    carried_landmarks,
)
from isomatch._models import JobRecord, MatchParameters, Shape
from isomatch._operations.jobs import cancel_job, start_match, wait_for_job, watch_job
from isomatch._operations.request_parts import listed
from isomatch._operations.results import get_result
from isomatch._operations.shapes import get_geometry
from isomatch._results import Match

FIXED: Final = ("dense", "simplify", "landmarks", "occlusion_cost", "refine")
"""Parameters of matches that carrying landmarks sets itself, or that it has no use for."""


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
    placed: Placements,
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
    placed
        Templates that are placed on their surfaces already; takes the others.
    progress
        Show a progress bar for each match.
    timeout
        Seconds to wait for each match; None for no limit.
    """
    limit = wait_given(timeout)
    matches = []
    wait = watch_job if progress else wait_for_job
    for job_id in job_ids:
        records: list[JobRecord] = []
        yield from wait(job_id, limit, records.append)
        matches.append(cast(Match, (yield from get_result(records[-1]))))
    for one in templates:
        if one not in placed:
            surface = one.surface or (yield from get_geometry(one.shape))
            placed[one] = PlacedLandmarks.of(one.landmarks, surface)
    every = [placed[one] for one in templates]
    return carried_landmarks(every, matches, (yield from get_geometry(specimen)))


def cancel_landmarks(job_ids: Sequence[str]) -> Operation[None]:
    """Cancel the matches that have not ended."""
    for job_id in job_ids:
        yield from cancel_job(job_id)
