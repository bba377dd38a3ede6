"""Uploads of meshes, prototypes and attributes: validated by a worker, answered with the record.

An upload that takes long to validate is answered with its job (202); the client then asks for what
it becomes.
"""

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, Any, BinaryIO, Final

from fastapi import Depends, Form, Query, Request, Response, UploadFile
from pydantic import AfterValidator, BaseModel
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import UploadFile as FormFile

from broker.contracts import (
    FieldProblem,
    IdempotencyRecord,
    JobRecord,
    JobState,
    PrototypeRecord,
    UploadPayload,
    sha256_of,
)
from broker.store import RecordLost, TooManyQueued
from broker.telemetry import logger
from service.dependencies import CallContext, Service
from service.http import (
    INVALID,
    MOST_FIELDS,
    ApiProblem,
    BadRequest,
    BodyStalled,
    EncodedBody,
    IdempotencyKeyReused,
    InvalidRequest,
    QuotaUsedUp,
    Reported,
    StorageFull,
    TooManyJobs,
    TooManyUploads,
    UnsupportedFormat,
    UploadCancelled,
    UploadTooLarge,
    media_type,
    responses,
    sent_as,
    short,
)
from service.jobs import LONGEST_WAIT, IdempotencyKey, Job
from service.names import LONGEST, base_name, showable
from service.records import RecordKind, RecordT

UploadName = Annotated[
    Annotated[str, AfterValidator(showable)] | None,
    Form(min_length=1, max_length=LONGEST, description="A name; default: that of the file."),
]


log = logger("isomatch.api")

_PARTS: Final = ("file", "name")

_FORM: Final = "multipart/form-data"

_ENDINGS: Final = {
    "model/gltf-binary": "glb",
    "model/gltf+json": "gltf",
    "text/csv": "csv",
    "application/zip": "zip",
}
"""Endings of files by their media types, besides those of the same name, such as model/obj."""

_GZIP: Final = b"\x1f\x8b"
"""First bytes of a file in gzip, which none of the formats begins with."""

_PLACE_INTERVAL: Final = 0.25
"""Seconds after which an upload that found no place looks again."""


async def _wait_for_place(context: CallContext, job: JobRecord, seconds: float) -> float:
    """Wait until the validation of an upload is admitted; return the seconds that are left.

    The wait also ends when the server stops or the client disconnects.

    Raises
    ------
    TooManyQueued
        It is not admitted within `seconds`.
    """
    service = context.service
    while seconds > 0 and not (service.closing.is_set() or await context.request.is_disconnected()):
        with suppress(TooManyQueued):
            await run_in_threadpool(service.queue.admit, job)
            return seconds
        await asyncio.sleep(_PLACE_INTERVAL)
        seconds = max(seconds - _PLACE_INTERVAL, 0.0)
    await run_in_threadpool(service.queue.admit, job)
    return seconds


async def _known_parts_once(request: Request) -> None:
    if media_type(request.headers.get("content-type")) not in ("", _FORM):
        raise UnsupportedFormat(sent_as(request, f"send {_FORM} with the file as its part `file`"))
    form = await request.form()
    wrong = {
        name: "The form has several parts of this name; send one"
        if name in _PARTS
        else f"There is no such part of this form; it has {' and '.join(_PARTS)}"
        for name in sorted(form)
        if name not in _PARTS or len(form.getlist(name)) > 1
    }
    if wrong:
        named = list(wrong.items())[:MOST_FIELDS]
        raise InvalidRequest(
            INVALID,
            tuple(FieldProblem(field=short(f"body.{name}"), message=text) for name, text in named),
        )
    await _refuse_gzip(form.get("file"))


async def _refuse_gzip(file: object) -> None:
    if not isinstance(file, FormFile):
        return
    start = await file.read(len(_GZIP))
    await file.seek(0)
    if start == _GZIP:
        raise _unsupported("The file is compressed by gzip; unpack it, and send what is in it.")


KnownPartsOnce: Final = Depends(_known_parts_once)
"""Refuses a body that is no form, a form with other parts, or with a part twice (what they are for
would be ignored), and a file in gzip."""


def name_and_type(
    file: UploadFile, name: str | None, type_of: Callable[[str], str | None], types: Sequence[str]
) -> tuple[str, str]:
    """Return the name of an upload, by default that of its file, and the type of the file.

    The type is that of the file's name, else of the name of the upload, else of the part's
    ``Content-Type``: programs call files that have no name "blob".

    Raises
    ------
    UnsupportedFormat
        The type is not one of `types`, which `type_of` returns for the name of a file.
    """
    filename = base_name(file.filename or "")
    sent = media_type(file.content_type)
    by_type = "file." + _ENDINGS.get(sent, sent.removeprefix("model/"))
    given = filter(None, map(type_of, (filename, name or "", by_type)))
    file_type = next(given, None)
    if file_type is None:
        endings = ", ".join("." + ending for ending in types)
        ends = f"The file name {filename[:100]!r} ends in no supported format"
        raise _unsupported(f"{ends}; use one of {endings}.")
    return (name or "").strip() or filename[:LONGEST], file_type


def _unsupported(detail: str) -> UnsupportedFormat:
    return UnsupportedFormat(detail, (FieldProblem(field="body.file", message=detail),))


@dataclass(frozen=True)
class UploadContext(CallContext):
    """The request that sends an upload, and the service that receives it."""

    key: IdempotencyKey = None
    wait: Annotated[
        float | None,
        Query(
            ge=0,
            le=LONGEST_WAIT,
            allow_inf_nan=False,
            description="Seconds to wait for the validation, after which the answer is 202;"
            " default: those of the service, 30.",
        ),
    ] = None


UploadContextOf = Annotated[UploadContext, Depends()]


@dataclass(frozen=True)
class UploadKind(RecordKind[RecordT]):
    """One kind of uploads, by the kind of records that they become.

    Parameters
    ----------
    deleted
        The problem reported if the record is deleted before the upload is answered.
    path
        Address that uploads are sent to.
    location
        Address under which the records are found.
    """

    deleted: type[ApiProblem]
    path: str
    location: str

    @staticmethod
    def named(known: RecordT, name: str) -> RecordT:
        """Return a record that was stored before, under the name of this upload of its bytes.

        The name of a prototype belongs to its version, and stays.
        """
        if isinstance(known, PrototypeRecord):
            return known
        return known.model_copy(update={"name": name})

    @property
    def location_header(self) -> dict[str, Any]:
        """OpenAPI entry of the header that names the record."""
        return {"Location": {"description": f"The {self.noun}.", "schema": {"type": "string"}}}

    @property
    def validating(self) -> dict[str, Any]:
        """OpenAPI entry of the answer while the upload is still being validated."""
        return {
            "model": Job,
            "description": f"The upload is still being validated by this job; ask for the"
            f" {self.noun} again",
            "headers": self.location_header,
        }

    def answers(
        self, model: type[BaseModel], known: str, *further: type[ApiProblem]
    ) -> dict[int | str, dict[str, Any]]:
        """Return the OpenAPI entries of the answers to an upload.

        Parameters
        ----------
        model
            Schema of the record.
        known
            Description of the answer for bytes that were uploaded before.
        further
            Problems besides those of every upload.
        """
        return {
            200: {"model": model, "description": known, "headers": self.location_header},
            201: {"description": f"A new {self.noun}", "headers": self.location_header},
            202: self.validating,
            **responses(
                *further,
                InvalidRequest,
                UploadTooLarge,
                UnsupportedFormat,
                BadRequest,
                BodyStalled,
                EncodedBody,
                IdempotencyKeyReused,
                UploadCancelled,
                StorageFull,
                QuotaUsedUp,
                TooManyJobs,
                TooManyUploads,
                self.deleted,
            ),
        }

    async def receive(
        self,
        context: UploadContext,
        file: UploadFile,
        describe: Callable[[str], UploadPayload],
    ) -> Response:
        """Store an upload, wait until it is validated, and return the answer.

        Parameters
        ----------
        context
            The request.
        file
            The upload.
        describe
            Returns the payload of the validation job of a file with this SHA-256.

        Raises
        ------
        UploadTooLarge, KeyReused
            The upload is refused unread.
        TooManyQueued
            As many uploads are being validated as may be, also after a wait.
        Reported
            The upload is not usable.
        UploadCancelled, ApiProblem
            The job was cancelled, or the record was deleted.
        """
        service = context.service
        if file.size is not None and file.size > service.settings.max_upload_bytes:
            raise UploadTooLarge.over(service.settings.max_upload_bytes)
        seconds = service.settings.validation_wait if context.wait is None else context.wait
        async with service.uploading:
            digest = await run_in_threadpool(sha256_of, file.file)
        payload, refused = describe(digest), None
        try:
            known, job_id = await self._accept(context, file, payload, digest)
        except TooManyQueued as error:
            refused = error.record
        if refused is not None:
            # Clients that send many files at once would be refused otherwise.
            seconds = await _wait_for_place(context, refused, seconds)
            known, job_id = await self._accept(context, file, payload, digest, refused)
        # Others take its place while the validation is awaited.
        await file.close()
        context.request.state.give_back_space()
        if known is not None:
            return self.show(self.named(known, payload.name), 200)
        job = await service.wait_for(job_id, seconds, context.request)
        return await run_in_threadpool(self._validated, service, payload, job_id, job)

    async def _accept(
        self,
        context: UploadContext,
        file: UploadFile,
        payload: UploadPayload,
        digest: str,
        admitted: JobRecord | None = None,
    ) -> tuple[RecordT | None, str]:
        """Return the record of content that is known, or submit its validation."""
        async with context.service.uploading:
            return await run_in_threadpool(
                self._submit, context, file.file, payload, digest, admitted
            )

    def show(self, record: RecordT, status: int = 200) -> Response:
        """Return the answer with a record and its address."""
        return Response(
            record.model_dump_json(),
            status_code=status,
            media_type="application/json",
            headers={"Location": f"{self.location}/{record.id}"},
        )

    def find(self, service: Service, record_id: str) -> Response:
        """Return the answer with a record, or with the job that still validates it.

        Raises
        ------
        Reported
            The upload turned out not to be usable after its sender was told to ask again.
        ApiProblem
            There is neither.
        """
        records = self.records(service.store)
        record = records.get(record_id)
        deferred = service.store.uploads.deferred(record_id)
        job = None if deferred is None else service.store.jobs.get(deferred)
        # A record whose content is lost is being restored.
        if job is not None and not job.state.ended and (record is None or records.lost(record_id)):
            return self._still_validating(service, record_id, job)
        if record is not None:
            return self.show(record)
        if job is not None and job.error is not None:
            raise Reported(job.error)
        raise self.missing(service, record_id)

    def _submit(
        self,
        context: UploadContext,
        data: BinaryIO,
        payload: UploadPayload,
        digest: str,
        admitted: JobRecord | None,
    ) -> tuple[RecordT | None, str]:
        service = context.service
        if context.key is not None:
            # Not the body as it was sent: its boundary differs each time.
            content = (b"POST", self.path.encode(), payload.model_dump_json().encode())
            ttl = service.settings.idempotency_ttl
            service.store.admission.bind(
                IdempotencyRecord.of(context.caller, context.key, content, ttl)
            )
        records = self.records(service.store)
        known = records.use(payload.upload)
        if known is not None and not records.lost(payload.upload):
            if admitted is not None:
                service.store.admission.release(admitted)
            return known, ""
        if known is not None:
            # The record stays: an equal upload may be restoring it now.
            log.warning("lost content is uploaded again", upload=payload.upload)
        job_id = service.queue.submit_validation(payload, data, context.origin, admitted, digest)
        return None, job_id

    def _validated(
        self, service: Service, payload: UploadPayload, job_id: str, job: JobRecord | None
    ) -> Response:
        if job is not None and job.state is JobState.FAILED and job.error is not None:
            raise Reported(job.error)
        records = self.records(service.store)
        record = records.get(payload.upload)
        succeeded = job is not None and job.state is JobState.SUCCEEDED
        if record is not None and (succeeded or not records.lost(payload.upload)):
            self._wait_for_disk(service, payload, job_id)
            return self.show(self.named(record, payload.name), 201)
        if succeeded:
            raise self._deleted_at_once()
        if job is None or job.state.ended:
            raise UploadCancelled(
                "The upload was cancelled before it was validated; send it again."
            )
        service.store.uploads.defer(payload.upload, job_id)
        service.store.jobs.wait_for_disk(job_id)
        return self._still_validating(service, payload.upload, job)

    def _wait_for_disk(self, service: Service, payload: UploadPayload, job_id: str) -> None:
        try:
            self.records(service.store).wait_for_disk(payload.upload)
        except RecordLost:
            # A restart of Redis that lost the record lost the end of its job, written later, too.
            job = service.store.jobs.get(job_id)
            if job is None or job.state is not JobState.SUCCEEDED:
                raise
            raise self._deleted_at_once() from None

    def _deleted_at_once(self) -> ApiProblem:
        detail = f"The {self.noun} was deleted as soon as it was validated; upload it again."
        return self.deleted(detail)

    def _still_validating(self, service: Service, record_id: str, job: JobRecord) -> Response:
        return Response(
            Job.of(job, service.queue).model_dump_json(),
            status_code=202,
            media_type="application/json",
            headers={"Location": f"{self.location}/{record_id}", "Retry-After": "1"},
        )
