"""Properties that all structures have in common: parameters, invariances, definition."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self, TypeAlias, TypeVar, get_args

from solver.errors import OptionError
from solver.parameters import ParameterSet

Degree: TypeAlias = Literal["yes", "approx", "no"]
"""Degree to which a structure is invariant to a class of transformations, as in Table 1."""

DEGREES: tuple[Degree, ...] = get_args(Degree)


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
class Structure(ParameterSet):
    """A structure by its name, with the values of its parameters.

    The docstring of each, up to the second paragraph, is its description in the service's
    catalogue; its class attributes and the declarations of its fields are the rest of the entry.

    Raises
    ------
    OptionError
        A value is out of range; the field is the parameter's name.
    """

    name: ClassVar[str]
    formula: ClassVar[str]
    """Definition."""
    source: ClassVar[str]
    """Section and equation of RR-7333, or the publication."""
    value_unit: ClassVar[str] = "1"
    """Unit of its values, in powers of length; "1" if they have none."""
    invariance: ClassVar[Invariance]
    remarks: ClassVar[str] = ""
    """Conditions and exceptions of the invariances."""
    spectral: ClassVar[bool] = False
    """Whether it is computed from Laplace-Beltrami eigenpairs."""
    colored: ClassVar[bool] = False
    """Whether it needs vertex colours."""

    def settled(self, length: float = 1.0) -> Self:
        """Return the choice with a value for every parameter.

        Parameters
        ----------
        length
            √area of the shapes, in their unit of length; 1 if they are normalised.
        """
        values = {
            name: known.settled(getattr(self, name), length)
            for name, known in self.parameters().items()
        }
        return replace(self, **values)


StructureT = TypeVar("StructureT", bound=Structure)


def chosen(
    given: StructureT | str, known: Mapping[str, type[StructureT]], field: str
) -> StructureT:
    """Return a choice; for a name, the one with default parameters.

    Parameters
    ----------
    given
        A choice or a name.
    known
        The structures there are, by name.
    field
        The option that is refused if there is no such structure.

    Raises
    ------
    OptionError
        There is no such structure.
    """
    name = given.name if isinstance(given, Structure) else given
    if not isinstance(name, str) or name not in known:
        raise OptionError(field, f"{name!r} is none of {', '.join(known)}")
    return given if isinstance(given, Structure) else known[name]()


def all_chosen(
    given: Sequence[StructureT | str], known: Mapping[str, type[StructureT]], field: str
) -> tuple[StructureT, ...]:
    """Return choices, at least one, as :func:`chosen` does; a place is part of the field.

    Raises
    ------
    OptionError
        There is none, there is no such structure, or a single one is not in a sequence.
    """
    if isinstance(given, str | Structure):
        name = given if isinstance(given, str) else given.name
        raise OptionError(field, f"{name!r} is not in a list: give one structure for each level")
    if not given:
        raise OptionError(field, "at least one is needed")
    return tuple(chosen(one, known, f"{field}.{place}") for place, one in enumerate(given))
