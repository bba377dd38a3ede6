"""Prototypes, learned from shapes."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from broker.contracts import (
    ExampleReport,
    JobRecord,
    PrototypeParameters,
    PrototypePayload,
    PrototypeResult,
    spectrum_key,
)
from broker.store import Store
from solver.control import Control
from solver.errors import MeshError
from solver.mesh import TriangleMesh
from solver.prototype import (
    CorrespondingExamples,
    PrototypeOptions,
    connected_examples,
    given_examples,
    learn_prototype,
    matched_examples,
    prototype_to_bytes,
)
from solver.shape import Shape
from worker.jobs.archives import record_of
from worker.jobs.failures import ShapeGone, UnusableShape
from worker.jobs.meshes import mesh_from_bytes, mesh_of
from worker.jobs.reporting import TOTAL, Reporter
from worker.jobs.spectra import spectrum_of
from worker.jobs.structures import descriptor_of, metric_of
from worker.pictures import packed_prototype

SPECTRA: Final = "spectra of the examples"

_SPECTRA_SHARE: Final = 0.4
_EXAMPLES_SHARE: Final = 0.4
"""Shares of the progress that are given to the spectra, and to what of the shapes corresponds."""


def options_of(parameters: PrototypeParameters) -> PrototypeOptions:
    """Return the solver's options, which have the same names.

    Parameters
    ----------
    parameters
        What was asked; some of it is not for the solver's options but for how shapes are made.
    """
    return PrototypeOptions(
        points=parameters.points,
        components=parameters.components,
        select_components=parameters.select_components,
        metric=tuple(map(metric_of, parameters.metrics)),
        descriptor=tuple(map(descriptor_of, parameters.descriptors)),
        sampling=tuple(map(metric_of, parameters.samplings)),
        seed=parameters.seed,
    )


def learn(
    payload: PrototypePayload, job: JobRecord, store: Store, holder: str, reporter: Reporter
) -> PrototypeResult:
    """Learn a prototype, and store it.

    Parameters
    ----------
    payload, job
        What is asked, and the job.
    store
        Where the shapes and their spectra are, and the prototype will be.
    holder
        See :func:`worker.jobs.spectra.spectrum_of`.
    reporter
        Of the job.

    Raises
    ------
    UnusableShape
        One of the shapes cannot be an example.
    ShapeGone
        It was deleted.
    OptionError, PrototypeError
        Nothing can be learned, or not so.
    Cancelled
        Through `reporter`.
    """
    started = time.perf_counter()
    shapes = _shapes(payload, store, holder, reporter.control(0.0, _SPECTRA_SHARE))
    middle = _SPECTRA_SHARE + _EXAMPLES_SHARE
    found = _examples(payload, shapes, reporter.control(_SPECTRA_SHARE, middle))
    options = options_of(payload.parameters)
    learned = learn_prototype(found.examples, options, reporter.control(middle, 1.0))
    prototype = replace(learned, warnings=(*learned.warnings, *found.warnings))
    archive = prototype_to_bytes(prototype)
    record = record_of(prototype, archive, payload.name, job.created)
    own = {
        "learned_from": _reports(payload, found),
        "reference": payload.shapes[payload.reference],
    }
    stored = store.prototypes.add(
        record.model_copy(update=own), archive, packed_prototype(prototype)
    )
    warnings = list(prototype.warnings)
    for place, shape in enumerate(shapes):
        warnings += [f"shapes.{place}: {warning}" for warning in shape.mesh.warnings]
    if stored.name != payload.name:
        warnings.append(
            f"the same prototype is known already, as version {stored.version} of {stored.name!r}"
        )
    return PrototypeResult(
        prototype=stored,
        parameters=payload.parameters,
        warnings=tuple(warnings),
        timings=reporter.seconds() | {TOTAL: time.perf_counter() - started},
    )


def _shapes(payload: PrototypePayload, store: Store, holder: str, control: Control) -> list[Shape]:
    shapes = []
    for place, shape in enumerate(payload.shapes):
        control.report(SPECTRA, place / len(payload.shapes))
        stored = store.shapes.mesh(shape)
        if stored is None:
            raise ShapeGone(shape)
        whole = mesh_from_bytes(stored)
        try:
            shapes.append(_shape(shape, whole, payload.parameters, store, holder, control))
        except MeshError as error:
            raise UnusableShape(f"shapes.{place}", str(error)) from error
    return shapes


def _shape(
    shape: str,
    whole: TriangleMesh,
    parameters: PrototypeParameters,
    store: Store,
    holder: str,
    control: Control,
) -> Shape:
    if whole.components > 1:
        raise MeshError(f"it has {whole.components} components; upload one of them")
    key = spectrum_key(parameters, shape, whole.n_vertices, whole.components)
    mesh = mesh_of(key, whole, store.spectra)
    spectrum = None
    if parameters.needs_spectrum:
        spectrum = spectrum_of(key, mesh, store.spectra, holder, control)
    return Shape(
        mesh,
        spectrum,
        normalise=parameters.normalise,
        eigenpairs=parameters.eigenpairs,
        geodesic_method=parameters.geodesic_method,
    )


def _examples(
    payload: PrototypePayload, shapes: Sequence[Shape], control: Control
) -> CorrespondingExamples:
    options, reference = options_of(payload.parameters), payload.reference
    if payload.correspondences is not None:
        given = [np.array(vertices, dtype=np.int64) for vertices in payload.correspondences]
        return given_examples(shapes, given, options, reference)
    if payload.parameters.correspondence == "shared_connectivity":
        return connected_examples(shapes, options, reference)
    return matched_examples(shapes, options, reference, control)


def _reports(payload: PrototypePayload, found: CorrespondingExamples) -> tuple[ExampleReport, ...]:
    kept = set(found.kept)
    return tuple(
        ExampleReport(
            shape=shape,
            used=place in kept,
            misfit=float(found.misfits[place]),
            reason=found.left_out.get(place),
        )
        for place, shape in enumerate(payload.shapes)
    )
