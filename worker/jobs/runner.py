"""Payload to solver to stored result: what each kind of job does."""

import gzip
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from redis.exceptions import RedisError

from broker.contracts import (
    DeliveryPayload,
    DissimilarityResult,
    JobKind,
    JobRecord,
    MatchPayload,
    MatchResult,
    PicturePayload,
    PrototypePayload,
    PrototypeValidationPayload,
    ShapeRecord,
    SpectrumPayload,
    TurnPayload,
    UploadPayload,
    ValidationPayload,
    is_prototype,
    spectrum_key,
    subject_of,
)
from broker.queue import JobQueue
from broker.store import NewerRecord, Store
from broker.telemetry import logger
from broker.upkeep import forget_deleted
from broker.webhooks import WebhookSettings
from solver.control import Control
from solver.errors import Cancelled
from solver.mesh import TriangleMesh, read_mesh
from worker.jobs.archives import stored_prototype, validate
from worker.jobs.delivery import deliver
from worker.jobs.failures import (
    ResultGone,
    ShapeGone,
    UploadGone,
    blaming,
    newer_version,
    problem_of,
)
from worker.jobs.matches import Side, arrays_of, match_prototype, match_shapes, result_from_blob
from worker.jobs.meshes import mesh_from_bytes, mesh_of, mesh_to_bytes
from worker.jobs.prototypes import learn
from worker.jobs.reporting import TOTAL, WAITING, Reporter
from worker.jobs.spectra import spectrum_of, surface_spectra
from worker.jobs.turns import Turn
from worker.pictures import (
    Hypothesis,
    draw_match,
    draw_matrix,
    draw_prototype_match,
    hypothesis_of,
    packed_geometry,
)

SPECTRA_SHARE = 0.4
"""Share of the progress that is given to the spectra, which dominate a first match."""

log = logger("isomatch.runner")


@dataclass(frozen=True)
class Runner:
    """Runs jobs, one at a time.

    Parameters
    ----------
    queue
        The way to further jobs, and to the store, where jobs come from and results go to.
    name
        What this runner holds jobs and locks by; unique to one run of one job.
    webhooks
        Where webhooks may go.
    """

    queue: JobQueue
    name: str
    webhooks: WebhookSettings = field(default_factory=WebhookSettings)

    @property
    def store(self) -> Store:
        """Where everything is."""
        return self.queue.store

    def run(self, job_id: str) -> None:
        """Run a job to its end, whatever that is; do nothing if it is not to be run (any more).

        Raises
        ------
        RedisError
            The store is away for longer than it is waited for; the job can be begun again.
        """
        if not self.store.jobs.claim(job_id, self.name):
            log.info("not to be run")
            return
        try:
            record = self.store.jobs.get(job_id)
        except NewerRecord:
            log.error("of a newer version, and cannot be read: this worker is to be upgraded")
            self.store.jobs.fail(job_id, self.name, newer_version())
            return
        assert record is not None
        log.info("begun")
        start = time.perf_counter()
        reporter = Reporter(self.store.jobs, record.id, self.name)
        try:
            result = self._result(record, reporter)
        except RedisError:
            raise
        except Cancelled:
            self.store.jobs.leave(job_id, self.name)
            log.info("cancelled")
        except Exception as error:
            problem = problem_of(error, record)
            # A traceback only where the error was not foreseen.
            log.warning("failed", problem=problem.slug, exc_info=problem.status >= 500)
            self._clean_up(record)
            self.store.jobs.fail(job_id, self.name, problem)
        else:
            kept = self.store.jobs.succeed(job_id, self.name, result)
            log.info("done", seconds=round(time.perf_counter() - start, 3), kept=kept)
        forget_deleted(self.store, subject_of(record.payload).named)
        stages = reporter.seconds() | {TOTAL: time.perf_counter() - start}
        if record.started is not None:
            stages[WAITING] = (record.started - record.created).total_seconds()
        self.store.tallies.time(record.kind, stages)

    def _result(self, record: JobRecord, reporter: Reporter) -> bytes | None:
        match record.payload:
            case ValidationPayload() as payload:
                self._validate(payload, record, reporter.control())
            case SpectrumPayload() as payload:
                self._compute_spectrum(payload, reporter.control())
            case PicturePayload() as payload:
                self._draw(payload)
            case DeliveryPayload() as payload:
                deliver(self.store, payload, self.webhooks)
            case MatchPayload() as payload:
                return self._match(payload, record.id, reporter)
            case PrototypePayload() as payload:
                learned = learn(payload, record, self.store, self.name, reporter)
                return learned.model_dump_json().encode()
            case PrototypeValidationPayload() as payload:
                validate(payload, record, self.store)
            case TurnPayload():
                Turn(self.queue, record, self.name).run()
        return None

    def _validate(self, payload: ValidationPayload, job: JobRecord, control: Control) -> None:
        data = self.store.shapes.candidate(payload.shape, payload.file_type, job.id)
        if data is None:
            # This is a repetition of what succeeded, or the upload waited for too long.
            if self.store.shapes.get(payload.shape) is None:
                raise UploadGone
            return
        control.report("reading the mesh", 0.0)
        mesh = read_mesh(data, payload.file_type)
        control.report("measuring the mesh", 0.5)
        record = ShapeRecord(
            id=payload.shape,
            name=payload.name,
            file_type=payload.file_type,
            bytes=len(data),
            vertices=mesh.n_vertices,
            faces=mesh.n_faces,
            area=mesh.area,
            components=mesh.components,
            closed=mesh.closed,
            has_colors=mesh.colors is not None,
            warnings=mesh.warnings,
            created=job.created,
        )
        packed = mesh_to_bytes(mesh), packed_geometry(mesh)
        accepted = self.store.shapes.accept(record, *packed, job.id)
        # One that was given up and came back may have made the shape meanwhile.
        if not accepted and self.store.shapes.get(payload.shape) is None:
            raise UploadGone

    def _compute_spectrum(self, payload: SpectrumPayload, control: Control) -> None:
        try:
            spectra = self.store.spectra
            # Somebody who computes it already needs no second one to wait for him.
            if not spectra.has(payload.key) and not spectra.locked(payload.key):
                control.report("spectrum", 0.0)
                mesh = mesh_of(payload.key, self._mesh(payload.shape), spectra)
                spectrum_of(payload.key, mesh, spectra, self.name, control)
        finally:
            self.store.spectra.settle(payload.key)

    def _match(self, payload: MatchPayload, job: str, reporter: Reporter) -> bytes:
        start = time.perf_counter()
        control, matching = reporter.control(0.0, SPECTRA_SHARE), reporter.control(SPECTRA_SHARE)
        if is_prototype(payload.source):
            prototype = stored_prototype(self.store, payload.source)
            control.report("spectrum of the target", 0.0)
            target = self._side("target", payload, control)
            waited = time.perf_counter() - start
            spectra = surface_spectra(payload.source, prototype.surfaces, self.store.spectra)
            result = match_prototype(prototype, target, payload, matching, spectra)
        else:
            control.report("spectrum of the source", 0.0)
            source = self._side("source", payload, control)
            control.report("spectrum of the target", 0.5)
            target = self._side("target", payload, control)
            waited = time.perf_counter() - start
            result = match_shapes(source, target, payload, matching)
        timings = dict(result.timings)
        # What the solver need not compute any more is still part of the wait.
        timings["spectra"] = timings.get("spectra", 0.0) + waited
        timings["total"] = time.perf_counter() - start
        self.store.jobs.set_arrays(job, arrays_of(result))
        return result.model_copy(update={"timings": timings}).model_dump_json().encode()

    def _side(
        self, field: Literal["source", "target"], payload: MatchPayload, control: Control
    ) -> Side:
        shape = payload.source if field == "source" else payload.target
        whole = self._mesh(shape)
        parameters = payload.parameters
        key = spectrum_key(parameters, shape, whole.n_vertices, whole.components)
        with blaming(field):
            mesh = mesh_of(key, whole, self.store.spectra)
        if not payload.needs_spectrum or mesh.components > 1:
            return Side(mesh, None)
        with blaming(field):
            spectrum = spectrum_of(key, mesh, self.store.spectra, self.name, control)
        return Side(mesh, spectrum)

    def _draw(self, payload: PicturePayload) -> None:
        packed = self.store.jobs.result(payload.job)
        drawn = self.store.jobs.get(payload.job)
        if packed is None or drawn is None:
            raise ResultGone("the result has expired")
        if drawn.kind is JobKind.DISSIMILARITIES:
            picture = self._drawn_matrix(packed)
        else:
            picture = self._drawn_match(result_from_blob(packed), payload.alternative)
        self.store.jobs.set_picture(payload.job, payload.alternative, picture)

    def _drawn_match(self, result: MatchResult, alternative: int | None) -> bytes:
        answer = hypothesis_of(result, alternative)
        if result.source_kind == "prototype":
            return self._drawn_prototype_match(result, answer)
        source, target = self._names((result.source, result.target))
        meshes = self._mesh(result.source), self._mesh(result.target)
        return draw_match(*meshes, answer, (source, target))

    def _drawn_prototype_match(self, result: MatchResult, answer: Hypothesis) -> bytes:
        prototype = stored_prototype(self.store, result.source)
        record = self.store.prototypes.get(result.source)
        name = "" if record is None else f"{record.name}, version {record.version}"
        (target,) = self._names((result.target,))
        mesh = self._mesh(result.target)
        return draw_prototype_match(prototype.positions, mesh, answer, (name, target))

    def _drawn_matrix(self, packed: bytes) -> bytes:
        result = DissimilarityResult.model_validate_json(gzip.decompress(packed))
        return draw_matrix(result, self._names(result.shapes))

    def _names(self, shapes: Sequence[str]) -> list[str]:
        records = self.store.shapes.records(shapes)
        return ["" if record is None else record.name for record in records]

    def _mesh(self, shape: str) -> TriangleMesh:
        stored = self.store.shapes.mesh(shape)
        if stored is None:
            raise ShapeGone(shape)
        return mesh_from_bytes(stored)

    def _clean_up(self, record: JobRecord) -> None:
        payload = record.payload
        if isinstance(payload, UploadPayload):
            uploads = self.queue.uploads(payload)
            uploads.reject(payload.upload, payload.file_type, record.id)
