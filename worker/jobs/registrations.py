"""Registration of a template to specimens, and registered templates as files."""

import io
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from broker.contracts import (
    MatchPayload,
    MatchResult,
    PrincipalComponent,
    RegistrationPayload,
    RegistrationResult,
    SpecimenReport,
)
from broker.store import Store
from solver import matching
from solver.arrays import FloatArray, IntArray
from solver.control import Control
from solver.errors import MeshError, OptionError
from solver.matching import Match, MatchOptions
from solver.mesh import TriangleMesh
from solver.templates import (
    RegisteredTemplate,
    ShapeStatistics,
    register_template,
    shape_statistics,
)
from solver.transfer.files import WrittenSurface, write_surface
from worker.jobs.context import JobContext
from worker.jobs.failures import ResultGone, ShapeGone, TimeUp, UnusableShape, none_usable
from worker.jobs.match_results import confidence_of
from worker.jobs.matches import MatchInput, load_shape
from worker.jobs.meshes import mesh_of, spectrum_of_shape
from worker.jobs.options import options_of
from worker.jobs.progress import SHARE_FOR_PARTS, TOTAL
from worker.jobs.registration_warnings import doubtful_specimens
from worker.jobs.transfers import solver_map
from worker.pictures import draw_components

_LEAST_VERTICES: Final = 4
"""Least number of vertices of a surface that can be registered."""

_STATISTICS_SHARE = 0.02
"""Share of the progress for the statistics."""

_TIME_UP: Final = "the job's time was up before it was registered; give fewer specimens"
"""Reason of specimens that the template is not registered to."""


@dataclass(frozen=True, eq=False)
class _Registered:
    """A template on one specimen, with the match that put it there.

    `boundary` is the length of the specimen's boundary over √area.
    """

    found: Match
    template: RegisteredTemplate
    boundary: float


def register(payload: RegistrationPayload, context: JobContext) -> bytes:
    """Register a template to specimens; store the arrays and return the document.

    A specimen that cannot be matched is reported with the reason, and does not end the job.

    Raises
    ------
    UnusableShape
        The template cannot be matched, or none of the specimens.
    TimeUp
        Before the template was registered to any specimen.
    ShapeGone
        The template was deleted, or none of the specimens can be matched and some were deleted.
    Cancelled
        Through the reporter.
    """
    start, reporter, store = time.perf_counter(), context.reporter, context.store
    names = [None if one is None else one.name for one in store.shapes.records(payload.shapes)]
    seconds = SHARE_FOR_PARTS * context.queue.settings.job_timeout
    parts = reporter.control(0.0, 1.0 - _STATISTICS_SHARE).within(seconds)
    parts.report("spectrum of the template", 0.0)
    template = load_shape("template", payload.template, payload, context, parts)
    if template.mesh.n_vertices < _LEAST_VERTICES:
        reason = f"it has fewer than {_LEAST_VERTICES} vertices, too few to be registered"
        raise UnusableShape("template", reason)
    found: list[_Registered | str] = []
    count = len(payload.shapes)
    for place in range(count):
        control = parts.between(place / count, (place + 1) / count)
        control.report(f"specimen {place + 1} of {count}", 0.0)
        found.append(_registered(payload, place, template, context, control))
    registered = [one for one in found if isinstance(one, _Registered)]
    if not registered and _TIME_UP in found:
        raise TimeUp(_TIME_UP)
    if not registered:
        reasons = [one if isinstance(one, str) else None for one in found]
        raise none_usable(payload.shapes, reasons, store)
    reporter.control(1.0 - _STATISTICS_SHARE).report("statistics", 0.0)
    positions = np.stack([one.template.positions for one in registered])
    statistics = shape_statistics(positions, payload.scale)
    mesh = template.mesh
    kept = [place for place, one in enumerate(found) if isinstance(one, _Registered)]
    arrays = _arrays(mesh, statistics, positions, [payload.shapes[place] for place in kept])
    store.results.set_arrays(context.record.id, arrays)
    record = store.shapes.get(payload.template)
    result = RegistrationResult(
        template=payload.template,
        template_name=None if record is None else record.name,
        vertices=int(mesh.numbering[0][-1]) + 1,
        faces=mesh.n_faces,
        scale=payload.scale,
        specimens=_reports(payload, names, found, statistics),
        components=tuple(
            PrincipalComponent(variance=variance, explained=explained)
            for variance, explained in zip(
                statistics.variances.tolist(), statistics.explained.tolist(), strict=True
            )
        ),
        warnings=(
            *(f"template: {warning}" for warning in mesh.warnings),
            *doubtful_specimens(
                [names[place] or payload.shapes[place] for place in kept],
                [_probability(one) for one in registered],
                [one.boundary for one in registered],
                mesh.relative_boundary,
            ),
        ),
        timings=reporter.seconds() | {TOTAL: time.perf_counter() - start},
    )
    return result.model_dump_json().encode()


def export_registered(
    result: RegistrationResult, job_id: str, specimen: int | None, file_type: str, store: Store
) -> bytes:
    """Return the mean shape, or the template registered to a specimen, as a file.

    Raises
    ------
    ResultGone
        The arrays are no longer kept.
    OptionError
        The template was not registered to this specimen.
    """
    arrays = _stored_arrays(job_id, store)
    if specimen is None:
        return write_surface(_surface("mean", arrays["mean"], arrays["faces"]), file_type)
    report = result.specimens[specimen]
    if not report.registered:
        raise OptionError("specimen", f"the template was not registered to it: {report.reason}")
    place = sum(one.registered for one in result.specimens[:specimen])
    name = report.name or report.shape
    return write_surface(_surface(name, arrays["positions"][place], arrays["faces"]), file_type)


def draw_registration(result: RegistrationResult, job_id: str, store: Store) -> bytes:
    """Draw the mean shape and its first principal components as PNG.

    Raises
    ------
    ResultGone
        The arrays are no longer kept.
    """
    arrays = _stored_arrays(job_id, store)
    return draw_components(
        arrays["mean"],
        arrays["faces"],
        arrays["components"],
        arrays["variances"],
        [one.explained for one in result.components],
        f"{result.template_name or 'template'}, {len(arrays['positions'])} specimens",
    )


def export_match_registered(
    result: MatchResult, payload: MatchPayload, file_type: str, store: Store
) -> bytes:
    """Return the source of a match with a dense map, registered to its target, as a file.

    Raises
    ------
    OptionError
        The match has no map of all vertices, or its source is a prototype.
    ShapeGone
        A shape was deleted.
    """
    dense = result.dense
    if dense is None or dense.inverse is None or result.source_kind == "prototype":
        raise OptionError("format", "it needs a match of two shapes with `dense`")
    source, target = (
        _matched_mesh(shape, payload, store) for shape in (payload.source, payload.target)
    )
    forwards = solver_map(dense, dense.inverse, forwards=True)
    found = register_template(source, target, forwards)
    rows, faces = _rows_of_file(source, found.positions), source.vertex_ids[source.faces]
    return write_surface(_surface(result.source_name or "source", rows, faces), file_type)


def _registered(
    payload: RegistrationPayload,
    place: int,
    template: MatchInput,
    context: JobContext,
    control: Control,
) -> _Registered | str:
    """Return the template on a specimen, or the reason why it is not there."""
    parameters, field = payload.parameters, f"shapes.{place}"
    if control.expired:
        return _TIME_UP
    try:
        specimen = load_shape(field, payload.shapes[place], payload, context, control)
        source, target = template.shape(parameters), specimen.shape(parameters)
        found = matching.match(source, target, options_of(MatchOptions, parameters), control)
        if found.dense is None:
            return _TIME_UP if control.expired else "its surface could not be registered"
        registered = register_template(template.mesh, specimen.mesh, found.dense, control)
        return _Registered(found, registered, specimen.mesh.relative_boundary)
    except UnusableShape as error:
        return error.field.message
    except (MeshError, OptionError, ShapeGone) as error:
        return str(error)


def _probability(one: _Registered) -> float | None:
    confidence = one.found.confidence
    return None if confidence is None else confidence.probability


def _reports(
    payload: RegistrationPayload,
    names: Sequence[str | None],
    found: Sequence[_Registered | str],
    statistics: ShapeStatistics,
) -> tuple[SpecimenReport, ...]:
    scores = iter(statistics.scores.tolist())
    return tuple(
        _failed(shape, name, one)
        if isinstance(one, str)
        else _report(shape, name, one, next(scores))
        for shape, name, one in zip(payload.shapes, names, found, strict=True)
    )


def _report(
    shape: str, name: str | None, one: _Registered, scores: Sequence[float]
) -> SpecimenReport:
    template, confidence = one.template, one.found.confidence
    return SpecimenReport(
        shape=shape,
        name=name,
        registered=True,
        reason=None,
        confidence=None if confidence is None else confidence_of(confidence),
        mean_distance=float(template.distances.mean()),
        max_distance=float(template.distances.max()),
        flipped=int(template.flipped.sum()),
        reflected=template.reflected,
        scores=tuple(scores),
    )


def _failed(shape: str, name: str | None, reason: str) -> SpecimenReport:
    return SpecimenReport(
        shape=shape,
        name=name,
        registered=False,
        reason=reason,
        confidence=None,
        mean_distance=None,
        max_distance=None,
        flipped=None,
        reflected=None,
        scores=(),
    )


def _matched_mesh(shape: str, payload: MatchPayload, store: Store) -> TriangleMesh:
    return mesh_of(spectrum_of_shape(payload.parameters, shape, store.shapes), shape, store)


def _arrays(
    mesh: TriangleMesh, statistics: ShapeStatistics, positions: FloatArray, shapes: Sequence[str]
) -> bytes:
    """Return the arrays as the bytes of an ``.npz`` file without pickled objects.

    `shapes` (M,) of the registered specimens; `faces` (F, 3); `positions` (M, W, 3) of the
    registered templates, row i of vertex i of the template's file; `mean` (W, 3); `components`
    (C, W, 3); `variances` (C,); `explained` (C,); `scores` (M, C).
    """
    stream = io.BytesIO()
    np.savez_compressed(
        stream,
        allow_pickle=False,
        shapes=np.array(shapes),
        faces=mesh.vertex_ids[mesh.faces],
        positions=_rows_of_file(mesh, positions),
        mean=_rows_of_file(mesh, statistics.mean),
        components=_rows_of_file(mesh, statistics.components),
        variances=statistics.variances,
        explained=statistics.explained,
        scores=statistics.scores,
    )
    return stream.getvalue()


def _rows_of_file(mesh: TriangleMesh, positions: FloatArray) -> FloatArray:
    """Positions by the vertex numbers of the file.

    Returns
    -------
    (..., W, 3), those of vertices that no face uses from the first one that is used: OBJ and GLB
    have no positions that are missing.
    """
    ids, own = mesh.numbering
    rows = np.repeat(positions[..., :1, :], int(ids[-1]) + 1, axis=-2)
    rows[..., ids, :] = positions[..., own, :]
    return rows


def _stored_arrays(job_id: str, store: Store) -> dict[str, npt.NDArray[Any]]:
    stored = store.results.arrays(job_id)
    if stored is None:
        raise ResultGone("the result has expired")
    with np.load(io.BytesIO(stored), allow_pickle=False) as arrays:
        return dict(arrays)


def _surface(name: str, vertices: FloatArray, faces: IntArray) -> WrittenSurface:
    return WrittenSurface(name, vertices, faces, ())
