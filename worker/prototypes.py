"""Prototypes: learned from shapes, or read from an archive that somebody uploaded."""

import time
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from solver.control import Control
from solver.errors import MeshError, PrototypeError
from solver.mesh import TriangleMesh
from solver.prototype import (
    CorrespondingExamples,
    Prototype,
    PrototypeOptions,
    connected_examples,
    given_examples,
    learn_prototype,
    matched_examples,
    prototype_from_bytes,
    prototype_to_bytes,
)
from solver.shape import Shape
from solver.structures import NoDescriptor
from worker.contracts import (
    ExampleReport,
    JobRecord,
    PrototypeParameters,
    PrototypePayload,
    PrototypeRecord,
    PrototypeResult,
    PrototypeStructures,
    PrototypeValidationPayload,
    prototype_id,
)
from worker.failures import PrototypeGone, ShapeGone, UnusableShape
from worker.meshes import mesh_from_bytes, mesh_of
from worker.reporting import TOTAL, Reporter
from worker.spectra import spectrum_of
from worker.store import Store
from worker.structures import choice_of, descriptor_of, metric_of

SPECTRA: Final = "spectra of the examples"

_SPECTRA_SHARE: Final = 0.4
_EXAMPLES_SHARE: Final = 0.4
"""Shares of the progress that are given to the spectra, and to what of the shapes corresponds."""

_LEFT_OUT: Final = "its match with the reference misfits those of the others"


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
        See :func:`worker.spectra.spectrum_of`.
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
    stored = store.prototypes.add(record.model_copy(update=own), archive)
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


def validate(payload: PrototypeValidationPayload, job: JobRecord, store: Store) -> None:
    """Make a prototype of a job's candidate.

    Raises
    ------
    PrototypeError
        It is none.
    PrototypeGone
        There is nothing to be read any more.
    """
    prototypes = store.prototypes
    data = prototypes.candidate(payload.prototype, payload.file_type, job.id)
    if data is None:
        # This is a repetition of what succeeded, or the upload waited for too long.
        if prototypes.get(payload.prototype) is None:
            raise PrototypeGone(payload.prototype)
        return
    record = record_of(prototype_from_bytes(data), data, payload.name, job.created)
    prototypes.add(record, data, job.id)


def stored_prototype(store: Store, prototype: str) -> Prototype:
    """Return a prototype.

    Raises
    ------
    PrototypeGone
        It was deleted.
    """
    archive = store.prototypes.archive(prototype)
    if archive is None:
        raise PrototypeGone(prototype)
    return prototype_from_bytes(archive)


def record_of(
    prototype: Prototype, archive: bytes, name: str, created: datetime
) -> PrototypeRecord:
    """Return what is shown of a prototype.

    Parameters
    ----------
    prototype, archive
        The prototype, also as bytes.
    name
        What it is to be called; the version is given when it is stored.
    created
        When it was asked for.

    Raises
    ------
    PrototypeError
        It is made of something that cannot be asked for.
    """
    values: dict[str, Any] = {
        "metric": tuple(choice_of(level.metric) for level in prototype.distances),
        "descriptor": tuple(
            choice_of(NoDescriptor() if level is None else level.descriptor)
            for level in prototype.descriptors
        ),
        "eigenpairs": prototype.eigenpairs,
        "geodesic_method": prototype.geodesic_method,
        "normalise": prototype.normalise,
    }
    try:
        parameters = PrototypeStructures.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise PrototypeError(f"not a sound prototype: {where}: {first['msg']}") from error
    return PrototypeRecord(
        id=prototype_id(archive),
        name=name,
        version=1,
        bytes=len(archive),
        points=prototype.points,
        components=prototype.components,
        examples=prototype.examples,
        parameters=parameters,
        learned_from=None,
        reference=None,
        warnings=prototype.warnings,
        created=created,
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
            raise UnusableShape(place, str(error)) from error
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
    key = parameters.spectrum_key(shape, whole.n_vertices)
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
            reason=None if place in kept else _LEFT_OUT,
        )
        for place, shape in enumerate(payload.shapes)
    )
