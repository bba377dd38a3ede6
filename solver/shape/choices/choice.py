"""What all choices of a structure have in common: parameters in ranges, and invariances."""

from dataclasses import Field, dataclass, field, fields, replace
from typing import Any, ClassVar, Literal, Self, TypeAlias, get_args

from solver.errors import OptionError

Degree: TypeAlias = Literal["yes", "approx", "no"]
"""Whether a structure is invariant to a class of transformations, in the words of Table 1."""

DEGREES: tuple[Degree, ...] = get_args(Degree)

Unit: TypeAlias = Literal["", "length", "area"]

_POWERS: dict[Unit, int] = {"": 0, "length": 1, "area": 2}


@dataclass(frozen=True)
class Invariance:
    """A row of Table 1.

    Parameters
    ----------
    bending
        Under inelastic deformations, which change the embedding and no length on the surface.
    topology
        Under holes and glued points.
    scale
        Under scaling, if shapes are not normalised.
    """

    bending: Degree
    topology: Degree
    scale: Degree


@dataclass(frozen=True)
class Parameter:
    """What is known of one parameter of a structure.

    Parameters
    ----------
    least, most
        Its range, ends included; of each item, if it is a sequence.
    default
        Its value when it is left out, in units of a surface of unit area.
    unit
        Of what kind of quantity it is: a length, an area, or a number without unit.
    longest
        How many items a sequence may have; 0 for a single number.
    """

    least: float
    most: float
    default: Any
    unit: Unit = ""
    longest: int = 0

    def check(self, name: str, value: Any) -> None:
        """Refuse a value out of range; ``None`` is fit for what has a unit.

        Raises
        ------
        OptionError
            The field is `name`.
        """
        if value is None and self.unit:
            return
        if self.longest and not 1 <= len(value) <= self.longest:
            raise OptionError(name, f"it must have from 1 to {self.longest} values")
        what = "a whole number" if self.whole else "a number"
        for item in value if self.longest else (value,):
            if not self.least <= item <= self.most or (self.whole and item != int(item)):
                raise OptionError(name, f"it must be {what} from {self.least:g} to {self.most:g}")

    @property
    def whole(self) -> bool:
        """Whether it is a number of things."""
        return isinstance(self.default, int)

    def plain(self, value: Any) -> Any:
        """Return a value in range as Python's own numbers, which hash alike."""
        kind = int if self.whole else float
        return tuple(map(kind, value)) if self.longest else kind(value)

    def settled(self, value: Any, length: float) -> Any:
        """Return the value, or for ``None`` the default on a surface of area `length`²."""
        if value is not None:
            return value
        factor = length ** _POWERS[self.unit]
        if self.longest:
            return tuple(item * factor for item in self.default)
        return self.default * factor


def parameter(known: Parameter) -> Any:
    """Declare a parameter as the field of a choice.

    What has a unit is ``None`` by default, for a value that suits the size of the shapes.
    """
    return field(default=None if known.unit else known.default, metadata={"parameter": known})


@dataclass(frozen=True)
class Structure:
    """A structure by its name, with the values of its parameters.

    Raises
    ------
    OptionError
        A value is out of range; the field is the parameter's name.
    """

    name: ClassVar[str]
    invariance: ClassVar[Invariance]
    spectral: ClassVar[bool] = False
    """Whether it is made of Laplace-Beltrami eigenpairs."""
    colored: ClassVar[bool] = False
    """Whether it needs vertex colours."""

    def __post_init__(self) -> None:
        for name, known in self.parameters().items():
            value = getattr(self, name)
            known.check(name, value)
            if value is not None:
                object.__setattr__(self, name, known.plain(value))

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Return the parameters by name."""
        return {entry.name: _known(entry) for entry in fields(cls)}

    def settled(self, length: float = 1.0) -> Self:
        """Return the choice with a value for every parameter.

        Parameters
        ----------
        length
            √area of the shapes, in their unit of length; 1 if they are normalised.
        """
        return replace(
            self,
            **{
                name: known.settled(getattr(self, name), length)
                for name, known in self.parameters().items()
            },
        )


def _known(entry: "Field[Any]") -> Parameter:
    known: Parameter = entry.metadata["parameter"]
    return known
