"""Matches of two shapes, or of a prototype and a shape."""

import time
from dataclasses import dataclass, replace
from typing import Final

from broker.contracts import (
    ConsistentMapsPayload,
    MatchParameters,
    MatchPayload,
    MatchResult,
    PrototypeParameters,
    PrototypePayload,
    RegistrationPayload,
    ShapeRecord,
    is_prototype,
)
from broker.store import Store
from solver import matching
from solver import prototype as prototypes
from solver.control import Control
from solver.matching import MatchOptions
from solver.mesh import TriangleMesh
from solver.prototype import Prototype, SurfaceSpectra
from solver.shape import Shape
from solver.shape.laplacian import Spectrum
from worker.jobs.archives import stored_prototype
from worker.jobs.context import JobContext, JobResult
from worker.jobs.failures import attributed_to
from worker.jobs.match_results import arrays_of, document_of, refinement_of, summary_of
from worker.jobs.meshes import mesh_of, spectrum_key_of
from worker.jobs.options import options_of
from worker.jobs.registration_warnings import parts_as_wholes
from worker.jobs.spectra import spectrum_of, surface_spectra

SPECTRA_SHARE: Final = 0.4
"""Share of the progress for the spectra, which take most of the time of a first match."""


@dataclass(frozen=True)
class MatchInput:
    """A shape of a match, or an example of a prototype.

    Parameters
    ----------
    mesh
        The mesh that is matched.
    spectrum
        Its spectrum on unit area; None if no metric or descriptor needs one.
    """

    mesh: TriangleMesh
    spectrum: Spectrum | None

    def shape(self, parameters: MatchParameters | PrototypeParameters) -> Shape:
        """Return the shape for the solver."""
        return Shape(
            self.mesh,
            self.spectrum,
            normalise=parameters.normalise,
            eigenpairs=parameters.eigenpairs,
            geodesic_method=parameters.geodesic_method,
        )


def match(payload: MatchPayload, context: JobContext) -> JobResult:
    """Match two shapes, or a prototype and a shape.

    Raises
    ------
    UnusableShape, OptionError
        A shape cannot be matched, or not with these parameters.
    ShapeGone, PrototypeGone
        The shapes or the prototype were deleted.
    Cancelled
        Through the reporter.
    """
    start = time.perf_counter()
    loading = context.reporter.control(0.0, SPECTRA_SHARE)
    solving = context.reporter.control(SPECTRA_SHARE)
    if is_prototype(payload.source):
        prototype = stored_prototype(context.store, payload.source)
        loading.report("spectrum of the target", 0.0)
        target = load_shape("target", payload.target, payload, context, loading)
        loaded = time.perf_counter()
        spectra = surface_spectra(payload.source, prototype.surfaces, context.store.spectra)
        result = match_prototype(prototype, target, payload, solving, spectra)
    else:
        loading.report("spectrum of the source", 0.0)
        source = load_shape("source", payload.source, payload, context, loading)
        loading.report("spectrum of the target", 0.5)
        target = load_shape("target", payload.target, payload, context, loading)
        loaded = time.perf_counter()
        result = match_shapes(source, target, payload, solving)
    timings = dict(result.timings)
    timings["spectra"] = timings.get("spectra", 0.0) + loaded - start
    timings["total"] = time.perf_counter() - start
    named = {"job": context.record.id, "timings": timings, **_subjects(payload, context.store)}
    return JobResult(
        result.model_copy(update=named).model_dump_json().encode(),
        arrays_of(result),
        summary_of(result),
    )


def _subjects(payload: MatchPayload, store: Store) -> dict[str, str | int | None]:
    """Names of source and target, of the request or as stored, and numbers of their vertices."""
    kept = store.prototypes if is_prototype(payload.source) else store.shapes
    source, target = kept.get(payload.source), store.shapes.get(payload.target)
    return {
        "source_name": payload.source_name or (None if source is None else source.name),
        "target_name": payload.target_name or (None if target is None else target.name),
        "source_file_vertices": source.file_vertices if isinstance(source, ShapeRecord) else None,
        "target_file_vertices": None if target is None else target.file_vertices,
    }


def match_shapes(
    source: MatchInput, target: MatchInput, payload: MatchPayload, control: Control
) -> MatchResult:
    """Match two shapes and return the result document.

    Raises
    ------
    UnusableShape, OptionError
        A shape cannot be matched, or not with these parameters.
    Cancelled
        Through `control`.
    """
    parameters = payload.parameters
    first, second = source.shape(parameters), target.shape(parameters)
    found = matching.match(first, second, options_of(MatchOptions, parameters), control)
    refined = None
    if found.refinement is not None:
        refined = refinement_of(found.refinement, source.mesh, target.mesh)
    if parameters.partial == "none":
        parts = parts_as_wholes(source.mesh, target.mesh)
        found = replace(found, warnings=(*found.warnings, *parts))
    return document_of(found, payload, target.mesh, refined)


def match_prototype(
    prototype: Prototype,
    target: MatchInput,
    payload: MatchPayload,
    control: Control,
    surface_spectrum: SurfaceSpectra,
) -> MatchResult:
    """Match a prototype with a shape and return the result document.

    Raises
    ------
    UnusableShape, OptionError
        The shape cannot be matched, or not with these parameters.
    Cancelled
        Through `control`.
    """
    parameters = payload.parameters
    # A prototype has its own metric and descriptor.
    default = MatchOptions()
    options = replace(
        options_of(MatchOptions, parameters), metric=default.metric, descriptor=default.descriptor
    )
    shape = target.shape(parameters)
    found = prototypes.match_prototype(prototype, shape, options, control, surface_spectrum)
    return document_of(found, payload, target.mesh)


def load_shape(
    field: str,
    shape: str,
    payload: MatchPayload | RegistrationPayload | ConsistentMapsPayload | PrototypePayload,
    context: JobContext,
    control: Control,
) -> MatchInput:
    """Return a shape with its spectrum, from the cache or computed.

    Parameters
    ----------
    field
        Field of the request that names the shape.
    shape
        Its id.
    payload
        Of the job.
    context
        Of the job.
    control
        Cancellation.

    Raises
    ------
    UnusableShape
        The shape cannot be matched.
    ShapeGone, ShapeLost
        It was deleted, or its content is lost.
    Cancelled
        Through `control`.
    """
    spectra = context.store.spectra
    key = spectrum_key_of(payload.parameters, shape, context.store.shapes)
    with attributed_to(field):
        mesh = mesh_of(key, shape, context.store)
        if not payload.needs_spectrum:
            return MatchInput(mesh, None)
        return MatchInput(mesh, spectrum_of(key, mesh, spectra, context.runner, control))
