"""Learning of prototypes from shapes."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from broker.contracts import ExampleReport, PrototypePayload, PrototypeResult, PrototypeSummary
from solver.control import Control
from solver.errors import OptionError
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
from worker.jobs.context import JobContext, JobResult
from worker.jobs.failures import attributed_to
from worker.jobs.matches import load_shape
from worker.jobs.options import options_of
from worker.jobs.progress import TOTAL
from worker.pictures import packed_prototype

SPECTRA: Final = "spectra of the examples"

_FEWEST: Final = 2
"""Examples that a class is learned from: of one shape nothing is known of how others vary."""

_SPECTRA_SHARE: Final = 0.4
_EXAMPLES_SHARE: Final = 0.4
"""Shares of the progress for the spectra, and for the correspondence of the examples."""


def learn(payload: PrototypePayload, context: JobContext) -> JobResult:
    """Learn a prototype, and store it.

    Raises
    ------
    UnusableShape
        One of the shapes cannot be an example.
    ShapeGone
        A shape was deleted.
    OptionError, PrototypeError
        No prototype can be learned, or not with these parameters.
    Cancelled
        Through the reporter.
    """
    start, reporter = time.perf_counter(), context.reporter
    middle = _SPECTRA_SHARE + _EXAMPLES_SHARE
    shapes = _load(payload, context, reporter.control(0.0, _SPECTRA_SHARE))
    found = _examples(payload, shapes, reporter.control(_SPECTRA_SHARE, middle))
    if len(found.examples) < _FEWEST:
        message = f"{'; '.join(found.warnings)}: a class is learned from {_FEWEST} examples or more"
        raise OptionError("shapes", message)
    options = options_of(PrototypeOptions, payload.parameters)
    learned = learn_prototype(found.examples, options, reporter.control(middle, 1.0))
    prototype = replace(learned, warnings=(*learned.warnings, *found.warnings))
    archive = prototype_to_bytes(prototype)
    record = record_of(prototype, archive, payload.name, context.record.created)
    own = {
        "learned_from": _reports(payload, found),
        "reference": payload.shapes[payload.reference],
    }
    stored = context.store.prototypes.add(
        record.model_copy(update=own), archive, packed_prototype(prototype)
    )
    warnings = list(prototype.warnings)
    for place, shape in enumerate(shapes):
        warnings += [f"shapes.{place}: {warning}" for warning in shape.mesh.warnings]
    if stored.name != payload.name:
        warnings.append(
            f"the same prototype is known already, as version {stored.version} of {stored.name!r}"
        )
    result = PrototypeResult(
        job=context.record.id,
        prototype=stored,
        parameters=payload.parameters,
        warnings=tuple(warnings),
        timings=reporter.seconds() | {TOTAL: time.perf_counter() - start},
    )
    return JobResult(
        result.model_dump_json().encode(), summary=PrototypeSummary(prototype=stored.id)
    )


def _load(payload: PrototypePayload, context: JobContext, control: Control) -> list[Shape]:
    shapes = []
    for place, shape in enumerate(payload.shapes):
        control.report(SPECTRA, place / len(payload.shapes))
        field = f"shapes.{place}"
        loaded = load_shape(field, shape, payload, context, control)
        with attributed_to(field):
            shapes.append(loaded.shape(payload.parameters))
    return shapes


def _examples(
    payload: PrototypePayload, shapes: Sequence[Shape], control: Control
) -> CorrespondingExamples:
    options, reference = options_of(PrototypeOptions, payload.parameters), payload.reference
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
