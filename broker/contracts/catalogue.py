"""The catalogue of all structures that can be chosen."""

from functools import cache

from pydantic import BaseModel, ConfigDict, Field

from broker.contracts.descriptors import DESCRIPTORS
from broker.contracts.metrics import METRICS
from broker.contracts.structures import Structure, described


class Structures(BaseModel):
    """What shapes can be endowed with, section 3 of the paper and Table 1."""

    model_config = ConfigDict(frozen=True)

    metrics: tuple[Structure, ...] = Field(description="Global structures: `metric` of a match.")
    descriptors: tuple[Structure, ...] = Field(
        description="Local structures: `descriptor` of a match."
    )


@cache
def catalogue() -> Structures:
    """Return all structures that can be chosen."""
    return Structures(
        metrics=tuple(map(described, METRICS.values())),
        descriptors=tuple(map(described, DESCRIPTORS.values())),
    )
