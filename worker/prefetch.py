"""Which spectra a job will need, so that all workers compute them before it begins."""

from worker.contracts import MatchPayload, PrototypePayload, SpectrumKey, is_prototype
from worker.store import Shapes


def wanted_spectra(payload: MatchPayload | PrototypePayload, shapes: Shapes) -> list[SpectrumKey]:
    """Return the names of the spectra that a job will look at, each once.

    Parameters
    ----------
    payload
        What the job is to do.
    shapes
        Where its shapes are; those that are gone, or cannot be used, have none.
    """
    if not payload.needs_spectrum:
        return []
    if isinstance(payload, MatchPayload):
        return _of_match(payload, shapes)
    known = filter(None, shapes.records(payload.shapes))
    return [
        payload.parameters.spectrum_key(shape.id, shape.vertices)
        for shape in known
        if shape.components == 1
    ]


def _of_match(payload: MatchPayload, shapes: Shapes) -> list[SpectrumKey]:
    parameters, keys = payload.parameters, []
    for shape_id in dict.fromkeys((payload.source, payload.target)):
        shape = None if is_prototype(shape_id) else shapes.get(shape_id)
        if shape is not None and (shape.components == 1 or parameters.largest_component):
            keys.append(parameters.spectrum_key(shape_id, shape.vertices, shape.components))
    return keys
