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
    """

    source: str | None = None
    target: str | None = None
    shapes: tuple[str, ...] = ()
    prototype: str | None = None
    name: str | None = None

    @property
    def named(self) -> tuple[str, ...]:
        """Ids of the shapes and prototypes under which the job is listed."""
        return self.shapes if self.prototype is None else (*self.shapes, self.prototype)


def subject_of(payload: Payload) -> Subject:
    """Return the subject of a job; empty if the job serves another job."""
    match payload:
        case MatchPayload(source=source, target=target) if is_prototype(source):
            return Subject(source, target, (target,), source)
        case (
            MatchPayload(source=source, target=target)
            | TransferPayload(source=source, target=target)
        ):
            return Subject(source, target, tuple(dict.fromkeys((source, target))))
        case BatchPayload(source=source, targets=targets) if is_prototype(source):
            return Subject(source, None, tuple(dict.fromkeys(targets)), source)
        case BatchPayload(source=source, targets=targets):
            return Subject(source, None, tuple(dict.fromkeys((source, *targets))))
        case DissimilaritiesPayload() | ConsistentMapsPayload():
            return Subject(shapes=payload.shapes)
        case PrototypePayload():
            return Subject(shapes=payload.shapes, name=payload.name)
        case RegistrationPayload(template=template, shapes=shapes):
            return Subject(template, shapes=tuple(dict.fromkeys((template, *shapes))))
        case ValidationPayload():
            return Subject(shapes=(payload.shape,), name=payload.name)
        case AttributesValidationPayload():
            return Subject(name=payload.name)
        case PrototypeValidationPayload():
            return Subject(prototype=payload.prototype, name=payload.name)
        case SpectrumPayload():
            return Subject(shapes=(payload.shape,))
    return Subject()
