"""Contracts of parameters and structures as the solver's values, and back: names are the same."""

from typing import Any, TypeVar

from pydantic import BaseModel

from broker.contracts import DESCRIPTORS, METRICS, Choice
from solver.parameters import ParameterSet
from solver.shape import choices

OptionsT = TypeVar("OptionsT", bound=ParameterSet)


def options_of(kind: type[OptionsT], parameters: BaseModel) -> OptionsT:
    """Return the solver's options.

    Parameters
    ----------
    kind
        Class of the options.
    parameters
        Parameters of a job, those of shapes and of the service among them.

    Raises
    ------
    OptionError
        The solver refuses a value.
    """
    values = {}
    for name, known in kind.parameters().items():
        value = _solver_value(getattr(parameters, name))
        one_for_all_levels = isinstance(known.default, tuple) and not isinstance(value, tuple)
        values[name] = (value,) if one_for_all_levels else value
    return kind(**values)


def choice_of(structure: choices.Structure) -> Choice:
    """Return the contract's choice of a structure, with all its parameters.

    Raises
    ------
    pydantic.ValidationError
        The structure cannot be chosen.
    """
    kind = (METRICS | DESCRIPTORS)[structure.name]
    parameters = {name: getattr(structure, name) for name in structure.parameters()}
    return kind.model_validate({"name": structure.name, **parameters})


def _solver_value(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(map(_solver_value, value))
    if isinstance(value, Choice):
        kind = choices.METRICS.get(value.name) or choices.DESCRIPTORS[value.name]
        return kind(**value.model_dump(exclude={"name"}))
    return value
