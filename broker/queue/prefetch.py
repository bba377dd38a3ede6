"""The spectra a job will need, so that workers compute them before it begins."""

from broker.contracts import MatchPayload, PrototypePayload, SpectrumKey, is_prototype, spectrum_key
from broker.store import Shapes


def wanted_spectra(payload: MatchPayload | PrototypePayload, shapes: Shapes) -> list[SpectrumKey]:
    """Return the keys of the spectra that a job will use, each once.

    Parameters
    ----------
    payload
        The job.
    shapes
        The stored shapes; those that are deleted or cannot be used have no spectrum.
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
