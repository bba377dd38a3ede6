"""Metrics and descriptors, as the service lists them."""

from pydantic import FiniteFloat

from isomatch._models.answer import Answer


class Invariance(Answer):
    """Invariance of a structure, if shapes are not normalised: a row of Table 1.

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
        Its name and its meaning.
    type
        ``"number"``, ``"integer"``, or ``"numbers"`` for a list.
    default
        Value if left out; of a length or an area, on a surface of unit area.
    minimum, maximum
        Its range, ends included.
    unit
        ``"length"``, ``"area"``, or ``"1"`` (of earlier services empty) without a unit.
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
        The name by which it is chosen.
    description, formula, source
        Meaning, definition, and section of the paper or publication.
    unit
        Unit of its values, in powers of length; ``"1"`` if they have none.
    invariance, remarks
        Invariances, with conditions and exceptions.
    spectral
        Whether it is made of Laplace-Beltrami eigenpairs.
    needs_colors
        Whether the shapes must have vertex colours.
    parameters
        Its parameters.
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
    """The structures that can be compared.

    Attributes
    ----------
    metrics, descriptors
        Global and local structures.
    """

    metrics: tuple[Structure, ...]
    descriptors: tuple[Structure, ...]
