"""Matches whose source is a prototype: what they take, and what the prototype says instead."""

from typing import Any, Final

from broker.contracts import (
    FieldProblem,
    MatchParameters,
    MatchPayload,
    PrototypeRecord,
    ShapeRecord,
)
from service.http import InvalidRequest
from service.matches.schemas import MatchRequest
from service.orders import use_prototype, use_shapes
from service.state import Service
from service.suitability import several_components, simplified_too_far

CANNOT_BE_MATCHED: Final = "These two cannot be matched, or not so; `errors` says why."

_ITS_OWN: Final = ("metric", "descriptor", "normalise", "eigenpairs", "geodesic_method")
"""Parameters that the prototype was learned with, and that hold for whatever is matched with it."""

_COARSE_POINTS: Final = 10
"""Of the coarsest level, unless others are asked for than by default: as the solver has it."""


def prototype_match(asked: MatchRequest, service: Service) -> MatchPayload:
    """Return the match of a prototype with a shape.

    Parameters
    ----------
    asked
        The request, whose source is the id of a prototype.
    service
        Where both are.

    Raises
    ------
    UnknownPrototype, UnknownShape
        There is no such prototype, or shape.
    InvalidRequest
        A parameter has no meaning for a prototype, or the shape cannot be matched with it.
    """
    prototype = use_prototype(service, "body.source", asked.source)
    target = use_shapes(service, {"body.target": asked.target})["body.target"]
    parameters = in_force(asked, prototype)
    wrong = (*_without_meaning(asked, parameters, prototype), *_unusable(target, parameters))
    if wrong:
        raise InvalidRequest(CANNOT_BE_MATCHED, tuple(wrong))
    return MatchPayload(source=asked.source, target=asked.target, parameters=parameters)


def in_force(asked: MatchRequest, prototype: PrototypeRecord) -> MatchParameters:
    """Return the parameters of a match, those that the prototype has as it has them."""
    own: dict[str, Any] = {name: getattr(prototype.parameters, name) for name in _ITS_OWN}
    own["points"] = min(asked.points, prototype.points)
    if asked.coarse_points == MatchParameters().coarse_points:
        own["coarse_points"] = _COARSE_POINTS
    if "orientation" not in asked.model_fields_set:
        own["orientation"] = prototype.surfaces > 0
    return asked.parameters().model_copy(update=own)


def _without_meaning(
    asked: MatchRequest, parameters: MatchParameters, prototype: PrototypeRecord
) -> list[FieldProblem]:
    wrong = []
    for name in _ITS_OWN:
        given, own = (getattr(one, _plural(name)) for one in (asked, parameters))
        if name in asked.model_fields_set and given != own:
            message = "the prototype has its own, with which it was learned; leave it out"
            wrong.append(FieldProblem(field=f"body.{name}", message=message))
    points_alone = "of a prototype points are matched, and no surface between them; leave it out"
    wrong += [
        FieldProblem(field=f"body.{name}", message=points_alone)
        for name in ("refine", "dense", "landmarks")
        if getattr(asked, name)
    ]
    if asked.orientation and not prototype.surfaces:
        message = "the prototype keeps no surfaces; leave it out, or learn the prototype again"
        wrong.append(FieldProblem(field="body.orientation", message=message))
    if asked.objective != "l2":
        message = 'a prototype is matched by likelihood; leave it out, or give "l2"'
        wrong.append(FieldProblem(field="body.objective", message=message))
    return wrong


def _plural(name: str) -> str:
    # With the parameters of structures, however these were named.
    return f"{name}s" if name in ("metric", "descriptor") else name


def _unusable(target: ShapeRecord, parameters: MatchParameters) -> list[FieldProblem]:
    shapes = {"body.target": target}
    wrong = several_components(parameters, shapes) + simplified_too_far(parameters, shapes)
    colored = [choice.name for choice in parameters.descriptors if choice.about.needs_colors]
    if colored and parameters.first_order_weight > 0.0 and not target.has_colors:
        message = f"the prototype knows {colored[0]!r}, and the shape has no vertex colours"
        wrong.append(FieldProblem(field="body.target", message=message))
    return wrong
