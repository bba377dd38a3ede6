"""Structures that can be chosen: the form of a choice, and the catalogue."""

from collections.abc import Iterable
from typing import Any, ClassVar, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Discriminator, Field

from broker.contracts.strict import Items, StrictModel

Degree: TypeAlias = Literal["yes", "approx", "no"]

LEVELS: Final = Items(1, 8)
"""One choice for each level."""


class Invariance(BaseModel):
    """Invariance of a structure, if shapes are not normalised: a row of Table 1."""

    model_config = ConfigDict(frozen=True)

    bending: Degree = Field(description="Deformations that keep all lengths on the surface.")
    topology: Degree = Field(description="Holes, and points glued together.")
    scale: Degree = Field(description="Scaling.")


class StructureParameter(BaseModel):
    """A parameter of a structure."""

    model_config = ConfigDict(frozen=True)

    name: str = Field(description="Name of the parameter.")
    description: str = Field(description="What it is.")
    type: Literal["number", "integer", "numbers"] = Field(description='"numbers" is a list.')
    default: int | float | tuple[float, ...] = Field(
        description="Value if left out; of a length or an area, on a surface of unit area."
    )
    minimum: int | float = Field(description="Least value.")
    maximum: int | float = Field(description="Greatest value.")
    unit: Literal["1", "length", "area"] = Field(
        description='"length" and "area" are in the shapes\' unit of length: √area if they are'
        ' normalised, the users\' own if not. Defaults are scaled with the shapes. "1": a number'
        " without a unit."
    )


class Structure(BaseModel):
    """A metric or a descriptor that can be chosen."""

    model_config = ConfigDict(frozen=True)

    name: str = Field(description="Name, as in `metric` or `descriptor` of a request.")
    description: str = Field(description="What it is.")
    formula: str = Field(description="Formula, as text.")
    source: str = Field(description="Section and equation of RR-7333, or the publication.")
    unit: str = Field(description='Of its values, in powers of length; "1" if they have none.')
    invariance: Invariance = Field(description="What does not change its values.")
    remarks: str = Field(description="Conditions and exceptions of the invariances; often none.")
    spectral: bool = Field(description="Whether it is made of Laplace-Beltrami eigenpairs.")
    needs_colors: bool = Field(description="Whether the shapes must have vertex colours.")
    parameters: tuple[StructureParameter, ...] = Field(description="Its parameters.")


class Structures(BaseModel):
    """The structures of shapes, section 3 of the paper and Table 1."""

    model_config = ConfigDict(frozen=True)

    metrics: tuple[Structure, ...] = Field(description="Global structures: `metric` of a match.")
    descriptors: tuple[Structure, ...] = Field(
        description="Local structures: `descriptor` of a match."
    )


class Choice(StrictModel):
    """A chosen structure: its name, and those of its parameters that differ from the defaults."""

    about: ClassVar[Structure]

    name: str


# Tags look like the names Pydantic gives to branches, which are no part of a field's address.
ONE: Final = "choice[one]"
SEVERAL: Final = "choice[levels]"
NAME: Final = "choice[name]"
UNKNOWN: Final = "choice[unknown]"


def one_or_several() -> Discriminator:
    """Return the discriminator between a choice for all levels and a list of choices."""
    return Discriminator(lambda given: SEVERAL if isinstance(given, list | tuple) else ONE)


def by_name(names: Iterable[str]) -> Discriminator:
    """Return the discriminator of structures by name: the name alone, or the field `name`."""
    known = tuple(names)

    def tag(given: Any) -> str | None:
        if isinstance(given, str):
            return NAME
        if isinstance(given, Choice):
            return f"choice[{given.name}]"
        if not isinstance(given, dict):
            return None
        name = given.get("name")
        return f"choice[{name}]" if isinstance(name, str) and name in known else UNKNOWN

    listed = ", ".join(map(repr, known))
    return Discriminator(
        tag,
        custom_error_type="structure_type",
        custom_error_message=f"Input should be one of {listed}, an object with one of these as"
        " its `name` beside its parameters; of a match also a list of such from the coarsest"
        " level on",
    )
