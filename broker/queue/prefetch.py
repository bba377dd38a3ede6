"""Which spectra a job will need, so that all workers compute them before it begins."""

from broker.contracts import MatchPayload, PrototypePayload, SpectrumKey, is_prototype, spectrum_key
from broker.store import Shapes


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
    named: tuple[str, ...] = (
        (payload.source, payload.target) if isinstance(payload, MatchPayload) else payload.shapes
    )
    wanted = [shape for shape in dict.fromkeys(named) if not is_prototype(shape)]
    parameters = payload.parameters
    return [
        spectrum_key(parameters, shape.id, shape.vertices, shape.components)
        for shape in shapes.records(wanted)
        if shape is not None and (shape.components == 1 or parameters.largest_component)
    ]
