"""Subjects of jobs: the shapes and prototypes that a payload names."""

from dataclasses import dataclass

from broker.contracts.jobs import (
    AttributesValidationPayload,
    BatchPayload,
    ConsistentMapsPayload,
    DissimilaritiesPayload,
    MatchPayload,
    Payload,
    PrototypePayload,
    PrototypeValidationPayload,
    RegistrationPayload,
    SpectrumPayload,
    TransferPayload,
    ValidationPayload,
)
from broker.contracts.prototypes import is_prototype


@dataclass(frozen=True)
class Subject:
    """Shapes and prototypes of a job.

    Parameters
    ----------
    source, target
        Of a match or a transfer; the template of a registration is its source. A batch has a source
        and many targets, which are in `shapes`.
    shapes
        All shapes, in the order in which the request named them, each once.
    prototype
        The matched or uploaded prototype.
    name
        Name of the upload, or of the prototype that is learned.
    names
        Names that the request gave the shapes, in its order; None for those they are stored under.
    match
        Id of the job of the match that something is carried along.
    """

    source: str | None = None
    target: str | None = None
    shapes: tuple[str, ...] = ()
    prototype: str | None = None
    name: str | None = None
    names: tuple[str | None, ...] = ()
    match: str | None = None

    @property
    def named(self) -> tuple[str, ...]:
        """Ids of the shapes and prototypes under which the job is listed."""
        return self.shapes if self.prototype is None else (*self.shapes, self.prototype)


def subject_of(payload: Payload) -> Subject:
    """Return the subject of a job; empty if the job serves another job."""
    match payload:
        case MatchPayload(source=source, target=target):
            learned = is_prototype(source)
            shapes = (target,) if learned else tuple(dict.fromkeys((source, target)))
            prototype = source if learned else None
            own = (payload.source_name, payload.target_name)
            return Subject(source, target, shapes, prototype, names=own)
        case TransferPayload(source=source, target=target):
            shapes = tuple(dict.fromkeys((source, target)))
            return Subject(source, target, shapes, match=payload.match)
        case BatchPayload(source=source, targets=targets):
            learned = is_prototype(source)
            shapes = tuple(dict.fromkeys(targets if learned else (source, *targets)))
            prototype = source if learned else None
            names = (payload.source_name, *payload.target_names)
            return Subject(source, None, shapes, prototype, names=names)
        case DissimilaritiesPayload() | ConsistentMapsPayload():
            return Subject(shapes=payload.shapes, names=payload.names or ())
        case PrototypePayload():
            return Subject(shapes=payload.shapes, name=payload.name)
        case RegistrationPayload(template=template, shapes=shapes):
            names = () if payload.names is None else (payload.template_name, *payload.names)
            return Subject(template, shapes=tuple(dict.fromkeys((template, *shapes))), names=names)
        case ValidationPayload():
            return Subject(shapes=(payload.shape,), name=payload.name)
        case AttributesValidationPayload():
            return Subject(name=payload.name)
        case PrototypeValidationPayload():
            return Subject(prototype=payload.prototype, name=payload.name)
        case SpectrumPayload():
            return Subject(shapes=(payload.shape,))
    return Subject()
