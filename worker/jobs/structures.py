"""Chosen structures, as the solver takes them."""

from broker.contracts import DESCRIPTORS, METRICS, Choice
from solver.shape import choices as structures


def metric_of(choice: Choice) -> structures.MetricChoice:
    """Return the solver's choice of a metric, which has the same name and parameters."""
    return structures.METRICS[choice.name](**choice.model_dump(exclude={"name"}))


def descriptor_of(choice: Choice) -> structures.DescriptorChoice:
    """Return the solver's choice of a descriptor, which has the same name and parameters."""
    return structures.DESCRIPTORS[choice.name](**choice.model_dump(exclude={"name"}))


def choice_of(structure: structures.MetricChoice | structures.DescriptorChoice) -> Choice:
    """Return the choice of a structure that the solver has made, with all its parameters.

    Raises
    ------
    pydantic.ValidationError
        It is none that can be asked for.
    """
    is_metric = isinstance(structure, structures.MetricChoice)
    kind = (METRICS if is_metric else DESCRIPTORS)[structure.name]
    parameters = {name: getattr(structure, name) for name in structure.parameters()}
    return kind.model_validate({"name": structure.name, **parameters})
