"""Names of downloaded results: those of the shapes, as in ``cat0-to-lion0.ply``."""

from typing import Final

from broker.contracts import (
    ConsistentMapsPayload,
    JobRecord,
    MatchPayload,
    RegistrationPayload,
    TransferPayload,
    is_prototype,
)
from service.dependencies import Service
from service.names import without_ending

_PART: Final = 35
"""Characters at the beginning and the end of a long name that are kept."""

_LONGEST: Final = 2 * _PART + 3


def result_stem(service: Service, job_id: str) -> str:
    """Return the name of the files of a job's result, without ending.

    That of a match has its source and target, that of a transfer also what was carried, that of a
    registration its template. Others are named by the id of the job.
    """
    payload = _payload(service, job_id)
    if isinstance(payload, MatchPayload):
        return "-to-".join(_ends(service, payload))
    if isinstance(payload, TransferPayload):
        match = _payload(service, payload.match)
        if not isinstance(match, MatchPayload):
            return job_id
        source, target = _ends(service, match)
        ends = (source, target) if payload.direction == "source_to_target" else (target, source)
        return f"{payload.what}-{'-to-'.join(ends)}"
    if isinstance(payload, RegistrationPayload):
        return f"{_stem(service, payload.template, payload.template_name)}-registration"
    return job_id


def registered_stem(service: Service, job_id: str, specimen: int) -> str:
    """Return the name of the file of a registered template, without ending."""
    payload = _payload(service, job_id)
    if isinstance(payload, MatchPayload):
        return "-on-".join(_ends(service, payload))
    if isinstance(payload, RegistrationPayload) and specimen < len(payload.shapes):
        template = _stem(service, payload.template, payload.template_name)
        given = None if payload.names is None else payload.names[specimen]
        return f"{template}-on-{_stem(service, payload.shapes[specimen], given)}"
    return f"{job_id}-{specimen}"


def map_stem(service: Service, job_id: str, source: int, target: int) -> str:
    """Return the name of the file of a map of all vertices, without ending."""
    payload = _payload(service, job_id)
    if isinstance(payload, MatchPayload):
        names = _ends(service, payload)
        return f"map-{names[source]}-to-{names[target]}"
    if isinstance(payload, ConsistentMapsPayload):
        given = payload.names or (None,) * len(payload.shapes)
        ends = (_stem(service, payload.shapes[one], given[one]) for one in (source, target))
        return f"map-{'-to-'.join(ends)}"
    return job_id


def _payload(service: Service, job_id: str) -> object:
    record: JobRecord | None = service.store.jobs.get(job_id)
    return None if record is None else record.payload


def _ends(service: Service, match: MatchPayload) -> tuple[str, str]:
    return (
        _stem(service, match.source, match.source_name),
        _stem(service, match.target, match.target_name),
    )


def _stem(service: Service, shape: str, given: str | None) -> str:
    """Name of a shape or a prototype without the ending of its file, or else its id."""
    kept = service.store.prototypes if is_prototype(shape) else service.store.shapes
    record = None if given else kept.get(shape)
    stem = without_ending(given or (shape if record is None else record.name))
    # Names of two shapes have to fit; they may differ at the end alone.
    return stem if len(stem) <= _LONGEST else f"{stem[:_PART]}...{stem[-_PART:]}"
