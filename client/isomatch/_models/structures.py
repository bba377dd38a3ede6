"""Metrics and descriptors, as the service lists them."""

from pydantic import FiniteFloat

from isomatch._models.answer import Answer


class Invariance(Answer):
    """To what a structure is invariant, if shapes are not normalised: a row of Table 1.

    Attributes
    ----------
    bending, topology, scale
        Deformations that keep lengths on the surface; holes and glued points; scaling: ``"yes"``,
        ``"approx"`` or ``"no"``.
    """

    bending: str
    topology: str
    scale: str


class StructureParameter(Answer):
    """A parameter of a structure.

    Attributes
    ----------
    name, description
        What it is called, and what it is.
    type
        ``"number"``, ``"integer"``, or ``"numbers"`` for a list.
    default
        What it is when left out; of what has a unit, on a surface of unit area.
    minimum, maximum
        Its range, ends included.
    unit
        ``"length"``, ``"area"``, or nothing.
    """

    name: str
    description: str
    type: str
    default: int | FiniteFloat | tuple[FiniteFloat, ...]
    minimum: int | FiniteFloat
    maximum: int | FiniteFloat
    unit: str


class Structure(Answer):
    """A metric or a descriptor that can be chosen.

    Attributes
    ----------
    name
        What it is chosen by.
    description, formula, source
        What it is, and where it is from.
    unit
        Of its values, in powers of length; ``"1"`` if they have none.
    invariance, remarks
        What does not change it, and what else must be known of that.
    spectral
        Whether it is made of Laplace-Beltrami eigenpairs.
    needs_colors
        Whether the shapes must have vertex colours.
    parameters
        What can be given beside its name.
    """

    name: str
    description: str
    formula: str
    source: str
    unit: str
    invariance: Invariance
    remarks: str
    spectral: bool
    needs_colors: bool
    parameters: tuple[StructureParameter, ...]


class Structures(Answer):
    """What can be compared of shapes.

    Attributes
    ----------
    metrics, descriptors
        Global and local structures.
    """

    metrics: tuple[Structure, ...]
    descriptors: tuple[Structure, ...]
