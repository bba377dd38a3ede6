"""Registration of a template to specimens."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from broker.contracts import (
    PrincipalComponent,
    RegistrationPayload,
    RegistrationResult,
    SpecimenReport,
)
from solver.arrays import FloatArray, npz_bytes
from solver.control import Control
from solver.matching import Match
from solver.mesh import TriangleMesh
from solver.templates import (
    RegisteredTemplate,
    ShapeStatistics,
    SurfaceDistance,
    register_template,
    shape_statistics,
    surface_distance,
)
from worker.jobs.context import JobContext, JobResult
from worker.jobs.failures import TimeUp, UnusableShape, none_usable, reason_of
from worker.jobs.match_results import confidence_of
from worker.jobs.matches import MatchInput, load_shape
from worker.jobs.progress import SHARE_FOR_PARTS, TOTAL
from worker.jobs.registered_files import rows_of_file
from worker.jobs.registration_warnings import (
    boundary_of,
    doubtful_specimens,
    named_warnings,
    own_warnings,
    unlike_sizes,
)
from worker.jobs.shape_names import shape_names
from worker.jobs.surface_matches import PAIR_FAILURES, TIME_UP, match_surfaces
from worker.pictures import source_view, target_view

_LEAST_VERTICES: Final = 4
"""Least number of vertices of a surface that can be registered."""

_STATISTICS_SHARE = 0.02
"""Share of the progress for the statistics."""


@dataclass(frozen=True, eq=False)
class _Registered:
    """A template on one specimen, with the match that put it there.

    `distance` is that from the specimen, `boundary` the length of the specimen's boundary over
    √area, and `warnings` are those of the specimen and of the match.
    """

    found: Match
    template: RegisteredTemplate
    distance: SurfaceDistance
    boundary: float
    warnings: tuple[str, ...]


def register(payload: RegistrationPayload, context: JobContext) -> JobResult:
    """Register a template to specimens.

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
    (template_name,) = shape_names([payload.template], [payload.template_name], store)
    names = shape_names(payload.shapes, payload.names, store)
    seconds = SHARE_FOR_PARTS * context.queue.settings.job_timeout
    parts = reporter.control(0.0, 1.0 - _STATISTICS_SHARE).within(seconds)
    parts.report("spectrum of the template", 0.0)
    template = load_shape("template", payload.template, payload, context, parts)
    if template.mesh.n_vertices < _LEAST_VERTICES:
        reason = f"it has fewer than {_LEAST_VERTICES} vertices, too few to be registered"
        raise UnusableShape("template", reason)
    found = _registered_to_all(payload, template, context, parts)
    registered = [one for one in found if isinstance(one, _Registered)]
    if not registered and TIME_UP in found:
        raise TimeUp(TIME_UP)
    if not registered:
        reasons = [one if isinstance(one, str) else None for one in found]
        raise none_usable(payload.shapes, reasons, store)
    reporter.control(1.0 - _STATISTICS_SHARE).report("statistics", 0.0)
    positions = np.stack([one.template.positions for one in registered])
    statistics = shape_statistics(positions, payload.scale)
    kept = [place for place, one in enumerate(found) if isinstance(one, _Registered)]
    shapes = [payload.shapes[place] for place in kept]
    arrays = _arrays(template.mesh, statistics, positions, shapes)
    result = _result(payload, template.mesh, found, names, statistics)
    timings = reporter.seconds() | {TOTAL: time.perf_counter() - start}
    added = {"job": context.record.id, "template_name": template_name, "timings": timings}
    return JobResult(result.model_copy(update=added).model_dump_json().encode(), arrays)


def _registered_to_all(
    payload: RegistrationPayload, template: MatchInput, context: JobContext, control: Control
) -> list[_Registered | str]:
    """Return the template on each specimen, or the reason why it is not there."""
    found, count = [], len(payload.shapes)
    for place in range(count):
        part = control.between(place / count, (place + 1) / count)
        part.report(f"specimen {place + 1} of {count}", 0.0)
        found.append(_registered(payload, place, template, context, part))
    return found


def _result(
    payload: RegistrationPayload,
    mesh: TriangleMesh,
    found: Sequence[_Registered | str],
    names: Sequence[str | None],
    statistics: ShapeStatistics,
) -> RegistrationResult:
    """Return the result, but for the name of the template and the timings."""
    called = [name or shape for name, shape in zip(names, payload.shapes, strict=True)]
    registered = [
        (name, one) for name, one in zip(called, found, strict=True) if isinstance(one, _Registered)
    ]
    # The mean has the orientation of the first specimen.
    standing = source_view(mesh.vertices, mesh.faces)
    registered_names = [name for name, _ in registered]
    sizes = statistics.alignment.sizes.tolist()
    components = zip(statistics.variances.tolist(), statistics.explained.tolist(), strict=True)
    return RegistrationResult(
        template=payload.template,
        template_name=None,
        vertices=mesh.vertex_rows,
        faces=mesh.n_faces,
        scale=payload.scale,
        specimens=_reports(payload, names, found, statistics),
        components=tuple(
            PrincipalComponent(variance=variance, explained=explained)
            for variance, explained in components
        ),
        view=target_view(standing, mesh.vertices, statistics.mean).rows(),
        warnings=(
            *(f"template: {warning}" for warning in mesh.warnings),
            *named_warnings((name, one.warnings) for name, one in registered),
            *doubtful_specimens(
                registered_names,
                [_probability(one) for _, one in registered],
                [one.boundary for _, one in registered],
                boundary_of(mesh),
            ),
            *(() if payload.scale else unlike_sizes(registered_names, sizes)),
        ),
        timings={},
    )


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
        return TIME_UP
    try:
        specimen = load_shape(field, payload.shapes[place], payload, context, control)
        source, target = template.shape(parameters), specimen.shape(parameters)
        found = match_surfaces(source, target, parameters, control)
        if isinstance(found, str):
            return found
        assert found.dense is not None
        registered = register_template(template.mesh, specimen.mesh, found.dense, control)
        positions = registered.positions
        distance = surface_distance(positions, template.mesh, specimen.mesh, control)
        warnings = *specimen.mesh.warnings, *own_warnings(found, template.mesh, specimen.mesh)
        return _Registered(found, registered, distance, boundary_of(specimen.mesh), warnings)
    except PAIR_FAILURES as error:
        return reason_of(error)


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
        mean_distance=one.distance.mean,
        max_distance=one.distance.greatest,
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


def _arrays(
    mesh: TriangleMesh, statistics: ShapeStatistics, positions: FloatArray, shapes: Sequence[str]
) -> bytes:
    """Return the arrays as the bytes of an ``.npz`` file without pickled objects.

    `shapes` (M,) of the registered specimens; `faces` (F, 3); `positions` (M, W, 3) of the
    registered templates, row i of vertex i of the template's file; `mean` (W, 3); `components`
    (C, W, 3); `variances` (C,); `explained` (C,); `scores` (M, C).
    """
    return npz_bytes(
        {
            "shapes": np.array(shapes),
            "faces": mesh.vertex_ids[mesh.faces],
            "positions": rows_of_file(mesh, positions),
            "mean": rows_of_file(mesh, statistics.mean),
            "components": rows_of_file(mesh, statistics.components),
            "variances": statistics.variances,
            "explained": statistics.explained,
            "scores": statistics.scores,
        }
    )
