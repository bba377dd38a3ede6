"""The spectra a job will need, so that workers compute them before it begins."""

from typing import TypeAlias

from broker.contracts import (
    ConsistentMapsPayload,
    MatchPayload,
    PrototypePayload,
    RegistrationPayload,
    SpectrumKey,
    is_prototype,
    spectrum_key,
    subject_of,
)
from broker.store import Shapes

SpectralPayload: TypeAlias = (
    MatchPayload | PrototypePayload | RegistrationPayload | ConsistentMapsPayload
)
"""Payload of a job that uses spectra of its shapes."""


def wanted_spectra(payload: SpectralPayload, shapes: Shapes) -> list[SpectrumKey]:
    """Return the keys of the spectra that a job will use, each once.

    Parameters
    ----------
    payload
        The job.
    shapes
        The stored shapes; those that are deleted have no spectrum.
    """
    if not payload.needs_spectrum:
        return []
    wanted = [shape for shape in subject_of(payload).shapes if not is_prototype(shape)]
    parameters = payload.parameters
    return [
        spectrum_key(parameters, shape) for shape in shapes.records(wanted) if shape is not None
    ]
