"""What the choice of a structure consists of, and the catalogue of what can be chosen."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Discriminator, Field

Degree: TypeAlias = Literal["yes", "approx", "no"]
Unit: TypeAlias = Literal["", "length", "area"]

GREATEST: Final = 1e30
"""Bound of lengths and areas, and of their inverses."""

LEVELS: Final = Field(min_length=1, max_length=8, strict=False)
"""One choice for each level. A JSON array arrives as a list, which is not strictly a tuple."""


class Invariance(BaseModel):
    """To what a structure is invariant, if shapes are not normalised: a row of Table 1."""

    model_config = ConfigDict(frozen=True)

    bending: Degree = Field(description="Deformations that keep all lengths on the surface.")
    topology: Degree = Field(description="Holes, and points glued together.")
    scale: Degree = Field(description="Scaling.")


@dataclass(frozen=True)
class About:
    """What a structure is.

    Parameters
    ----------
    formula, source
        Its definition, and where it is from.
    unit
        Of its values; "1" if they have none.
    invariance
        Bending, topology, scale.
    spectral
        Whether it is made of Laplace-Beltrami eigenpairs.
    colored
        Whether it needs vertex colours.
    remarks
        What else must be known of its invariances.
    """

    formula: str
    source: str
    unit: str
    invariance: tuple[Degree, Degree, Degree]
    spectral: bool = False
    colored: bool = False
    remarks: str = ""


@dataclass(frozen=True)
class Suited:
    """A parameter that suits the size of the shapes when it is null.

    Parameters
    ----------
    default
        What it is then on a surface of unit area.
    unit
        What it is a quantity of.
    """

    default: float | tuple[float, ...]
    unit: Unit


class Choice(BaseModel):
    """A structure: its name, and those of its parameters that are not to be as by default."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    about: ClassVar[About]

    name: str


class StructureParameter(BaseModel):
    """A parameter of a structure."""

    model_config = ConfigDict(frozen=True)

    name: str
    description: str
    type: Literal["number", "integer", "numbers"] = Field(description='"numbers" is a list.')
    default: int | float | tuple[float, ...] = Field(
        description="What it is when left out; of what has a unit, on a surface of unit area."
    )
    minimum: int | float
    maximum: int | float
    unit: Unit = Field(
        description='"length" and "area" are in the shapes\' unit of length: √area if they are'
        " normalised, the users' own if not. When left out, they suit the size of the shapes."
    )


class Structure(BaseModel):
    """A metric or a descriptor that can be chosen."""

    model_config = ConfigDict(frozen=True)

    name: str
    description: str
    formula: str
    source: str = Field(description="Section and equation of RR-7333, or the publication.")
    unit: str = Field(description='Of its values, in powers of length; "1" if they have none.')
    invariance: Invariance
    remarks: str = Field(description="What else must be known of its invariances; often nothing.")
    spectral: bool = Field(description="Whether it is made of Laplace-Beltrami eigenpairs.")
    needs_colors: bool = Field(description="Whether the shapes must have vertex colours.")
    parameters: tuple[StructureParameter, ...]


def described(kind: type[Choice]) -> Structure:
    """Return the catalogue's entry of a structure."""
    about, schema = kind.about, kind.model_json_schema()
    bending, topology, scale = about.invariance
    return Structure(
        name=schema["properties"]["name"]["const"],
        description=" ".join((kind.__doc__ or "").split()),
        formula=about.formula,
        source=about.source,
        unit=about.unit,
        invariance=Invariance(bending=bending, topology=topology, scale=scale),
        remarks=about.remarks,
        spectral=about.spectral,
        needs_colors=about.colored,
        parameters=tuple(
            _parameter(kind, name, field)
            for name, field in schema["properties"].items()
            if name != "name"
        ),
    )


def _parameter(kind: type[Choice], name: str, schema: dict[str, Any]) -> StructureParameter:
    suited = [m for m in kind.model_fields[name].metadata if isinstance(m, Suited)]
    value = next((option for option in schema.get("anyOf", ()) if option["type"] != "null"), schema)
    several = value["type"] == "array"
    limits = value["items"] if several else value
    return StructureParameter(
        name=name,
        description=schema["description"],
        type="numbers" if several else value["type"],
        default=suited[0].default if suited else schema["default"],
        minimum=limits["minimum"],
        maximum=limits["maximum"],
        unit=suited[0].unit if suited else "",
    )


# Tags look like the names Pydantic gives to branches, which are no part of a field's address.
ONE: Final = "choice[one]"
SEVERAL: Final = "choice[levels]"
NAME: Final = "choice[name]"
UNKNOWN: Final = "choice[unknown]"


def one_or_several() -> Discriminator:
    """Tell a choice for all levels from a list of choices."""
    return Discriminator(lambda given: SEVERAL if isinstance(given, list | tuple) else ONE)


def by_name(names: Iterable[str]) -> Discriminator:
    """Tell a structure by its name, which is all that is given, or a field of it."""
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
        " its `name` beside its parameters, or a list of such from the coarsest level on",
    )
