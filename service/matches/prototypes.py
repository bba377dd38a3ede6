"""Matches whose source is a prototype: the parameters in force, and those not supported."""

from collections.abc import Mapping
from typing import Any, Final

from broker.contracts import (
    FieldProblem,
    MatchParameters,
    PrototypeRecord,
    ShapeRecord,
)
from service.dependencies import Service
from service.matches.schemas import SourceRequest
from service.prototypes import use_prototype
from service.shapes import refuse, simplified_too_far, use_shapes

REFUSED: Final = "These two cannot be matched with these parameters; `errors` says why."

_FIXED: Final = ("metric", "descriptor", "normalise", "eigenpairs", "geodesic_method")
"""Parameters of a match that are those the prototype was learned with."""


def prototype_parameters(
    asked: SourceRequest, targets: Mapping[str, str], service: Service
) -> MatchParameters:
    """Return the parameters of the match of a prototype with one or several shapes.

    Parameters
    ----------
    asked
        The request, whose source is the id of a prototype.
    targets
        Ids of the shapes by the fields that name them, such as ``body.target``.
    service
        The service that keeps both.

    Raises
    ------
    UnknownPrototype, UnknownShape
        The prototype or the shape does not exist.
    InvalidRequest
        A parameter is not supported with a prototype, or the shape cannot be matched with it.
    """
    prototype = use_prototype(service, "body.source", asked.source)
    shapes = use_shapes(service, targets)
    parameters = in_force(asked, prototype)
    wrong = (*_unsupported(asked, parameters, prototype), *_unusable(shapes, parameters))
    refuse(wrong, REFUSED)
    return parameters


def in_force(asked: SourceRequest, prototype: PrototypeRecord) -> MatchParameters:
    """Return the parameters of a match, with those of the prototype where it fixes them."""
    own: dict[str, Any] = {name: getattr(prototype.parameters, name) for name in _FIXED}
    if "points" not in asked.model_fields_set:
        # More that are asked for are warned of; the default is not asked for.
        own["points"] = min(asked.points, prototype.points)
    own["partial"] = "none"
    own["orientation"] = asked.orientation and prototype.surfaces > 0
    return asked.parameters(MatchParameters).model_copy(update=own)


def _unsupported(
    asked: SourceRequest, parameters: MatchParameters, prototype: PrototypeRecord
) -> list[FieldProblem]:
    wrong = []
    for name in _FIXED:
        given, own = (getattr(one, _plural(name)) for one in (asked, parameters))
        if name in asked.model_fields_set and given != own:
            message = "differs from the value the prototype was learned with; leave it out"
            wrong.append(FieldProblem(field=f"body.{name}", message=message))
    wrong += [
        FieldProblem(
            field=f"body.{name}",
            message=f"`{name}` is not supported with a prototype; leave it out",
        )
        for name in ("refine", "dense", "landmarks", "third_order")
        if getattr(asked, name)
    ]
    if asked.partial not in ("detected", "none"):
        message = 'parts are not supported with a prototype; leave it out, or set it to "none"'
        wrong.append(FieldProblem(field="body.partial", message=message))
    if asked.objective != "l2":
        message = 'only "l2" is supported with a prototype; leave it out, or set it to "l2"'
        wrong.append(FieldProblem(field="body.objective", message=message))
    return wrong


def _plural(name: str) -> str:
    # With the parameters of structures, however these were named.
    return f"{name}s" if name in ("metric", "descriptor") else name


def _unusable(shapes: Mapping[str, ShapeRecord], parameters: MatchParameters) -> list[FieldProblem]:
    wrong = simplified_too_far(parameters, shapes)
    colored = [choice.name for choice in parameters.descriptors if choice.about.needs_colors]
    if colored and parameters.first_order_weight > 0.0:
        message = f"it has no vertex colours, which the prototype's {colored[0]!r} needs"
        without = (field for field, shape in shapes.items() if not shape.has_colors)
        wrong += [FieldProblem(field=field, message=message) for field in without]
    return wrong
