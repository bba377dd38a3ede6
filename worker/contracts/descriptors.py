"""The descriptors that can be chosen, sections 3.5 to 3.8 of the paper."""

import math
from typing import Annotated, Final, Literal, TypeAlias, get_args

from pydantic import ConfigDict, Field, Tag
from pydantic.json_schema import SkipJsonSchema
from typing_extensions import TypeAliasType

from worker.contracts.structures import (
    GREATEST,
    LEVELS,
    NAME,
    ONE,
    SEVERAL,
    UNKNOWN,
    About,
    Choice,
    Suited,
    by_name,
    one_or_several,
)

DescriptorName: TypeAlias = Literal["none", "hks", "si_hks"]

_SHORTEST: Final = math.log(10.0) / (100.0 * math.pi)
_HEAT_TIMES: Final = tuple(_SHORTEST ** (1.0 - i / 31.0) for i in range(32))


class NoDescriptor(Choice):
    """No descriptor: the first-order term is left out."""

    about = About("0", "", "1", ("yes", "yes", "yes"))

    name: Literal["none"]


class HeatKernelSignature(Choice):
    """How much heat is left at a point after several times, relative to the mean of all points."""

    about = About(
        "h_t(x, x) = Σ exp(-λ_i t) φ_i(x)², times area / Σ exp(-λ_i t)",
        "3.6",
        "1",
        ("yes", "approx", "no"),
        spectral=True,
    )

    name: Literal["hks"]
    times: Annotated[
        tuple[Annotated[float, Field(ge=1.0 / GREATEST, le=GREATEST)], ...] | None,
        Suited(_HEAT_TIMES, "area"),
    ] = Field(
        default=None,
        min_length=1,
        max_length=128,
        strict=False,
        description="Times t, in the square of the shapes' unit of length. Null for 32 from 0.0073"
        " to 1 of their area, each greater than the last by the same factor.",
    )


class ScaleInvariantHeatKernelSignature(Choice):
    """Magnitudes of the Fourier transform of d/dτ log h over τ = log₂ t."""

    about = About(
        "|F(d/dτ log h_t(x, x))|, t = 2^τ", "3.7", "1", ("yes", "approx", "yes"), spectral=True
    )

    name: Literal["si_hks"]
    frequencies: int = Field(
        default=6, ge=1, le=40, description="How many of the lowest frequencies are kept."
    )


class UnknownDescriptor(Choice):
    """What an object without the name of a descriptor is refused by."""

    model_config = ConfigDict(extra="ignore")

    name: DescriptorName


DESCRIPTORS: Final[dict[str, type[Choice]]] = {
    "none": NoDescriptor,
    "hks": HeatKernelSignature,
    "si_hks": ScaleInvariantHeatKernelSignature,
}

Descriptor = TypeAliasType(
    "Descriptor",
    Annotated[
        Annotated[DescriptorName, Tag(NAME)]
        | Annotated[NoDescriptor, Tag("choice[none]")]
        | Annotated[HeatKernelSignature, Tag("choice[hks]")]
        | Annotated[ScaleInvariantHeatKernelSignature, Tag("choice[si_hks]")]
        | SkipJsonSchema[Annotated[UnknownDescriptor, Tag(UNKNOWN)]],
        by_name(get_args(DescriptorName)),
    ],
)
"""A descriptor: its name, or that and its parameters."""

DescriptorByLevel: TypeAlias = Annotated[
    Annotated[Descriptor, Tag(ONE)] | Annotated[tuple[Descriptor, ...], LEVELS, Tag(SEVERAL)],
    one_or_several(),
]
"""A descriptor for all levels, or one for each."""


def descriptor_choice(given: Choice | str) -> Choice:
    """Return a descriptor with its parameters, for a name those by default."""
    return DESCRIPTORS[given](name=given) if isinstance(given, str) else given
