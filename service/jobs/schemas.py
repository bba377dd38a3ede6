"""Jobs as the API shows them."""

from collections.abc import Sequence
from datetime import datetime
from typing import Final, Literal, Self, TypeAlias
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict, Field

from broker.contracts import (
    AttributesValidationPayload,
    Delivery,
    JobKind,
    JobRecord,
    JobState,
    MatchSummary,
    Problem,
    Progress,
    PrototypePayload,
    PrototypeSummary,
    PrototypeValidationPayload,
    Summary,
    TransferPayload,
    ValidationPayload,
    exports_of,
    maps_vertices,
    registered_formats,
    subject_of,
)
from broker.queue import JobQueue

SPECTRA: Final = "spectra"
"""Stage of a queued job whose spectra are being computed."""

_Awaited: TypeAlias = Literal["worker", "turn"]

_WITHOUT_RESULT: Final = (JobState.FAILED, JobState.CANCELLED)

_NEAR: Final = 20
"""Position up to which a queued job is asked for its spectra."""

MOST_NAMED: Final = 20
"""Shapes listed in a job. A collection may have thousands, and each event repeats the job."""


class JobLinks(BaseModel):
    """Addresses of a job and of its result.

    Those of the result are there from the beginning, but answer 409 until the job has succeeded.
    They are null (`exports` and `registered` empty) if the job has failed or was cancelled, if the
    result is no longer kept, and for kinds that have none.
    """

    model_config = ConfigDict(frozen=True)

    self: str = Field(description="The job.")
    events: str = Field(description="The changes of the job, as server-sent events.")
    result: str | None = Field(description="Its result, JSON.")
    picture: str | None = Field(description="Its result as a picture.")
    arrays: str | None = Field(description="Its result as NumPy arrays.")
    exports: tuple[str, ...] = Field(description="Its result as files of other formats.")
    registered: tuple[str, ...] = Field(
        description="The source of a dense match on its target, as files; the template of a"
        " registration on its first specimen, and with `?specimen=` on another one."
    )
    map: str | None = Field(
        description="A map of all vertices as CSV, of a dense match or consistent maps; with"
        " `?source=` and `?target=` another one. Of a prototype there is none."
    )
    resource: str | None = Field(
        description="What the job has made: the shape, prototype or attribute file of an upload, or"
        " the prototype that was learned, while the result is kept; null before, and for other"
        " kinds."
    )
    match: str | None = Field(description="The match along which it transfers values.")
    partial: str | None = Field(
        description="What is known of a batch or a comparison while it runs, and afterwards; null"
        " for other kinds, and for a comparison without a result."
    )


class JobWebhook(Delivery):
    """Receiver of the notification that a job has ended, and the state of its delivery."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True)

    url: str = Field(description="Address of the receiver, without its query.")


class Job(BaseModel):
    """A job."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "id": "5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                    "kind": "match",
                    "batch": None,
                    "state": "running",
                    "source": "9b74c9897bac770ffc029102a200c5de",
                    "target": "37b51d194a7513e45b56f6524f2d51f2",
                    "shapes": [
                        "9b74c9897bac770ffc029102a200c5de",
                        "37b51d194a7513e45b56f6524f2d51f2",
                    ],
                    "shape_count": 2,
                    "prototype": None,
                    "summary": None,
                    "name": None,
                    "names": ["cat0.off", "cat1.off"],
                    "parameters": {"points": 64, "dense": True},
                    "progress": {"stage": "spectrum of the source", "fraction": 0.2},
                    "created": "2026-03-01T12:00:00Z",
                    "started": "2026-03-01T12:00:01Z",
                    "ended": None,
                    "position": None,
                    "waiting_for": None,
                    "error": None,
                    "caller": None,
                    "webhook": {
                        "url": "https://example.org/isomatch",
                        "state": "pending",
                        "attempts": 0,
                        "last_attempt": None,
                        "status": None,
                        "error": None,
                        "next_attempt": None,
                    },
                    "links": {
                        "self": "/v1/jobs/5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                        "events": "/v1/jobs/5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f/events",
                        "result": "/v1/jobs/5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f/result",
                        "picture": "/v1/jobs/5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f/result.png",
                        "arrays": "/v1/jobs/5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f/result.npz",
                        "exports": ["/v1/jobs/5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f/result.csv"],
                        "registered": [],
                        "map": None,
                        "resource": None,
                        "match": None,
                        "partial": None,
                    },
                }
            ]
        },
    )

    id: str = Field(description="Id of the job.")
    kind: JobKind = Field(description="Kind of the job.")
    batch: str | None = Field(
        description="Id of the batch that it is a match of; null for a job of its own."
    )
    state: JobState = Field(
        description="queued, then running, and finally succeeded, failed or cancelled."
    )
    source: str | None = Field(
        description="Id of the source of a match or a batch, a shape or a prototype, or of a"
        " transfer, or of the template of a registration; null for other kinds."
    )
    target: str | None = Field(
        description="Id of the target of a match or transfer; null for other kinds."
    )
    shapes: tuple[str, ...] = Field(
        description=f"Ids of its shapes, each once; only the first {MOST_NAMED} if there are more."
    )
    shape_count: int = Field(description="Number of its shapes.")
    prototype: str | None = Field(
        description="Id of the prototype that is matched, that was uploaded, or that was learned,"
        " while the result of learning is kept; null for none."
    )
    summary: MatchSummary | None = Field(
        description="The answer in brief, of a match that has succeeded and is still kept; null"
        " for other kinds and for matches of earlier versions."
    )
    name: str | None = Field(
        description="Name of the prototype that is learned, or of the upload; null for other kinds."
    )
    names: tuple[str | None, ...] = Field(
        description="Names that the request gave its shapes, in the order of the request, the"
        f" source first; the first {MOST_NAMED}, and none for kinds that take no names. Null for"
        " the name that a shape is stored under."
    )
    parameters: dict[str, str | int | float | bool | None] = Field(
        description="Parameters of the request that differ from their defaults, but those that are"
        " lists or have parameters of their own, which the result has. A transfer has `what`."
    )
    progress: Progress = Field(
        description='How far it is. The stage of a queued job is "queued", or "spectra" while its'
        " spectra, which are computed beforehand, are all that it waits for."
    )
    created: datetime = Field(description="When it was requested.")
    started: datetime | None = Field(description="When it was begun; null before.")
    ended: datetime | None = Field(description="When it ended; null before.")
    position: int | None = Field(
        description="Number of jobs ahead of it in the queue; null once it has begun, and of a"
        " match of a batch until a worker will soon be free for it."
    )
    waiting_for: _Awaited | None = Field(
        description="What a job waits for: a `worker`, if none is alive, or its `turn`. A"
        " running comparison or batch waits while all workers work for other jobs. Null for a job"
        " that does not wait."
    )
    error: Problem | None = Field(description="Why it failed; null if it did not.")
    caller: str | None = Field(
        description="Name of the API key it was requested with; null where none is needed."
    )
    webhook: JobWebhook | None = Field(
        description="Its webhook and the state of the delivery; null for none."
    )
    links: JobLinks = Field(description="Addresses of the job and of its result.")

    @classmethod
    def of(cls, record: JobRecord, queue: JobQueue) -> Self:
        """Return a stored job as the API shows it."""
        return cls.several([record], queue)[0]

    @classmethod
    def several(cls, records: Sequence[JobRecord], queue: JobQueue) -> tuple[Self, ...]:
        """Return stored jobs as the API shows them."""
        queued = [record for record in records if record.state is JobState.QUEUED]
        giving_way = queue.giving_way(records)
        served = bool(queued or giving_way) and queue.any_worker()
        positions = queue.rq.positions(queued) if queued else []
        succeeded = [one.id for one in records if one.state is JobState.SUCCEEDED]
        gone = set(succeeded) - queue.store.results.kept(succeeded)
        summaries = dict(zip(succeeded, queue.store.results.summaries(succeeded), strict=True))
        place = {one.id: known for one, known in zip(queued, positions, strict=True)}
        return tuple(
            cls._of(
                record,
                place.get(record.id),
                _waiting_for(record, place.get(record.id), served, record.id in giving_way),
                served and _awaits_spectra(record, place.get(record.id), queue),
                record.id in gone,
                summaries.get(record.id),
            )
            for record in records
        )

    @classmethod
    def _of(
        cls,
        record: JobRecord,
        position: int | None,
        waiting_for: _Awaited | None,
        awaits_spectra: bool,
        gone: bool,
        summary: Summary | None,
    ) -> Self:
        path = f"/v1/jobs/{record.id}"
        error, subject = record.error, subject_of(record.payload)
        learned = summary.prototype if isinstance(summary, PrototypeSummary) else None
        prototype = subject.prototype or learned
        return cls(
            id=record.id,
            kind=record.kind,
            batch=record.batch,
            state=record.state,
            source=subject.source,
            target=subject.target,
            shapes=subject.shapes[:MOST_NAMED],
            shape_count=len(subject.shapes),
            prototype=prototype,
            summary=summary if isinstance(summary, MatchSummary) else None,
            name=subject.name,
            names=subject.names[:MOST_NAMED],
            parameters=_parameters(record),
            progress=Progress(stage=SPECTRA, fraction=0.0) if awaits_spectra else record.progress,
            created=record.created,
            started=record.started,
            ended=record.ended,
            position=position,
            waiting_for=waiting_for,
            error=None if error is None else error.model_copy(update={"instance": path}),
            caller=record.caller,
            webhook=_webhook(record),
            links=_links(record, path, gone or record.state in _WITHOUT_RESULT, prototype),
        )


def _links(record: JobRecord, path: str, without: bool, prototype: str | None) -> JobLinks:
    kind, payload, match = record.kind, record.payload, subject_of(record.payload).match
    exports = () if without else exports_of(payload)
    registered = () if without else registered_formats(payload)
    return JobLinks(
        self=path,
        events=f"{path}/events",
        result=f"{path}/result" if kind.has_result and not without else None,
        picture=f"{path}/result.png" if kind.has_picture and not without else None,
        arrays=f"{path}/result.npz" if kind.has_arrays and not without else None,
        exports=tuple(f"{path}/result.{one}" for one in exports),
        registered=tuple(f"{path}/registered.{one}" for one in registered),
        map=f"{path}/map.csv" if maps_vertices(payload) and not without else None,
        resource=_resource(record, prototype),
        match=None if match is None else f"/v1/jobs/{match}",
        partial=_partial(record, without),
    )


def _resource(record: JobRecord, prototype: str | None) -> str | None:
    if record.state is not JobState.SUCCEEDED:
        return None
    match record.payload:
        case ValidationPayload(shape=shape):
            return f"/v1/shapes/{shape}"
        case AttributesValidationPayload(attributes=attributes):
            return f"/v1/attributes/{attributes}"
        case PrototypeValidationPayload() | PrototypePayload() if prototype is not None:
            return f"/v1/prototypes/{prototype}"
    return None


def depends_on_queue(record: JobRecord) -> bool:
    """Whether a job looks different when others begin or end, though its record stays the same."""
    sliced = record.kind in (JobKind.BATCH, JobKind.DISSIMILARITIES)
    return record.state is JobState.QUEUED or (sliced and not record.state.ended)


def _awaits_spectra(record: JobRecord, position: int | None, queue: JobQueue) -> bool:
    """Whether spectra of its shapes are all that a queued job waits for."""
    if position is None or position > _NEAR:
        return False
    ahead = queue.spectra_ahead(record)
    return ahead > 0 and position <= ahead


def _waiting_for(
    record: JobRecord, position: int | None, served: bool, gives_way: bool
) -> _Awaited | None:
    if gives_way:
        return "turn" if served else "worker"
    if record.state is not JobState.QUEUED:
        return None
    if not served:
        return "worker"
    # A job without a place was taken by a worker, which is about to begin; a match of a batch may
    # have none yet.
    return "turn" if position is not None or record.batch is not None else None


_CHOSEN: Final = {
    JobKind.REGISTRATION: {"largest_component"},
    JobKind.CONSISTENT_MAPS: {"largest_component"},
}
"""Parameters that requests have, of kinds that set the others themselves."""


def _parameters(record: JobRecord) -> dict[str, str | int | float | bool | None]:
    if isinstance(record.payload, TransferPayload):
        return {"what": record.payload.what}
    parameters = getattr(record.payload, "parameters", None)
    if parameters is None:
        return {}
    # Of some kinds a request has only one of them; the others are no choice of its own.
    asked = _CHOSEN.get(record.kind)
    changed = parameters.model_dump(mode="json", include=asked, exclude_defaults=True)
    return {name: one for name, one in changed.items() if not isinstance(one, list | dict)}


def _partial(record: JobRecord, without: bool) -> str | None:
    if record.kind is JobKind.BATCH:  # its matches have results of their own
        return f"/v1/batches/{record.id}"
    compared = record.kind is JobKind.DISSIMILARITIES and not without
    return f"/v1/dissimilarities/{record.id}" if compared else None


def _webhook(record: JobRecord) -> JobWebhook | None:
    if record.webhook is None:
        return None
    # Receivers often put a secret in the query.
    url = urlsplit(record.webhook.url)._replace(query="", fragment="").geturl()
    delivery = record.delivery or Delivery()
    return JobWebhook(url=url, **dict(delivery))


class JobPage(BaseModel):
    """One page of the jobs, the newest first."""

    items: tuple[Job, ...] = Field(description="The jobs.")
    next_cursor: str | None = Field(description="Cursor of the next page; null on the last.")
