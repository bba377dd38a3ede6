"""Declaration of parameters: type, range, default, unit, meaning and source, once and for all.

A parameter is a field of a frozen dataclass::

    rho: float = parameter(1.5, "Radius of ...", above=1.0, most=4.0, source="section 4.1")

The dataclass checks its values by these declarations. The service's contracts, the client's types,
the command line's options, the page's form and the tables of the documents are generated from them
(``make generate``).
"""

from dataclasses import dataclass, field, fields
from typing import Any, Literal, TypeAlias

from solver.errors import OptionError

Unit: TypeAlias = Literal["", "length", "area", "seconds"]
Topic: TypeAlias = Literal["", "Shapes", "Structures", "Solver", "Mixtures"]
"""Heading under which a parameter is documented; none for those most users look for first."""

SIZE_POWERS: dict[Unit, int] = {"length": 1, "area": 2}
"""Units of quantities that grow with the shapes, by their power of length."""


@dataclass(frozen=True)
class Parameter:
    """Declaration of a parameter.

    Parameters
    ----------
    default
        Value if left out; of a length or an area, on a surface of unit area. None for a parameter
        that is optional.
    meaning
        Description. The first sentence alone is the summary.
    least, above, most
        Range: the lower end, included or excluded, and the upper end, included; of each item of a
        sequence. None where there is none.
    one_of
        Values of an enumeration.
    longest
        Greatest number of items of a sequence; 0 for a single value.
    unit
        Kind of quantity; "" for a number without unit.
    source
        Symbol, section or equation of RR-7333.
    topic
        Heading under which it is documented.
    """

    default: Any
    meaning: str
    least: float | None = None
    above: float | None = None
    most: float | None = None
    one_of: tuple[str, ...] = ()
    longest: int = 0
    unit: Unit = ""
    source: str = ""
    topic: Topic = ""

    @property
    def scales(self) -> bool:
        """Whether the default is proportional to the size of the shapes."""
        return self.unit in SIZE_POWERS

    @property
    def optional(self) -> bool:
        """Whether ``None`` is a value."""
        return self.scales or self.default is None

    def checked(self, name: str, value: Any, whole: bool) -> Any:
        """Return a value in range, numbers as Python's own.

        Raises
        ------
        OptionError
            The value is out of range; the field is `name`.
        """
        if value is None and self.optional:
            return None
        if self.one_of and value not in self.one_of:
            raise OptionError(name, f"{value!r} is none of {', '.join(self.one_of)}")
        if self.most is None:
            return value
        if not self.longest:
            return self._number(name, value, whole)
        if not 1 <= len(value) <= self.longest:
            raise OptionError(name, f"it must have from 1 to {self.longest} values")
        return tuple(self._number(name, item, whole) for item in value)

    def settled(self, value: Any, length: float) -> Any:
        """Return the value, or for ``None`` the default on a surface of area `length`²."""
        if value is not None or not self.scales:
            return value
        factor = length ** SIZE_POWERS[self.unit]
        if self.longest:
            return tuple(item * factor for item in self.default)
        return self.default * factor

    def _number(self, name: str, value: Any, whole: bool) -> int | float:
        assert self.most is not None
        if self.above is None:
            assert self.least is not None
            right, lower = self.least <= value <= self.most, f"from {self.least:g}"
        else:
            right, lower = self.above < value <= self.most, f"greater than {self.above:g}, up"
        if not right or (whole and value != int(value)):
            kind = "a whole number" if whole else "a number"
            raise OptionError(name, f"it must be {kind} {lower} to {self.most:g}")
        return int(value) if whole else float(value)


def parameter(default: Any, meaning: str, **declared: Any) -> Any:
    """Declare a parameter as the field of a :class:`ParameterSet`.

    A length or an area is ``None`` by default, which stands for a value that suits the size of the
    shapes.

    Parameters
    ----------
    default, meaning, declared
        See :class:`Parameter`.
    """
    known = Parameter(default, meaning, **declared)
    return field(default=None if known.scales else default, metadata={"parameter": known})


@dataclass(frozen=True)
class ParameterSet:
    """Values of declared parameters, checked on construction.

    Raises
    ------
    OptionError
        A value is out of range; the field is the parameter's name.
    """

    def __post_init__(self) -> None:
        for entry in fields(self):
            known: Parameter = entry.metadata["parameter"]
            whole = entry.type in (int, int | None)
            value = known.checked(entry.name, getattr(self, entry.name), whole)
            object.__setattr__(self, entry.name, value)

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Return the declarations by name."""
        return {entry.name: entry.metadata["parameter"] for entry in fields(cls)}
