"""Chosen structures, as the solver takes them."""

from solver import structures
from worker.contracts.structures import Choice


def metric_of(choice: Choice) -> structures.MetricChoice:
    """Return the solver's choice of a metric, which has the same name and parameters."""
    return structures.METRICS[choice.name](**choice.model_dump(exclude={"name"}))


def descriptor_of(choice: Choice) -> structures.DescriptorChoice:
    """Return the solver's choice of a descriptor, which has the same name and parameters."""
    return structures.DESCRIPTORS[choice.name](**choice.model_dump(exclude={"name"}))
