"""Keys of the spectrum cache."""

from dataclasses import dataclass
from typing import Final, Protocol

from broker.contracts.shapes import ShapeRecord

SPECTRUM_VERSION: Final = 2
"""Increased whenever the solver's spectra change, so that cached ones are not used."""


@dataclass(frozen=True)
class SpectrumKey:
    """Everything a spectrum depends on: shape and its format, component, simplification, size.

    The cache is common to all tenants, and the same bytes may be two meshes in two formats.

    Parameters
    ----------
    shape
        Id of the shape.
    eigenpairs
        Number of eigenpairs.
    largest_component
        Whether only the shape's largest component is used.
    simplify
        Vertices of the simplified mesh; None if the mesh was not simplified.
    file_type
        Format in which the shape was uploaded.
    """

    shape: str
    eigenpairs: int
    largest_component: bool = False
    simplify: int | None = None
    file_type: str = ""

    @property
    def mesh_name(self) -> str:
        """Name of the simplified mesh."""
        return f"{self._part}:mesh:v{SPECTRUM_VERSION}"

    @property
    def _part(self) -> str:
        part = "largest" if self.largest_component else "whole"
        detail = "full" if self.simplify is None else str(self.simplify)
        return f"{self.shape}:{self.file_type}:{part}:{detail}"

    def __str__(self) -> str:
        return f"{self._part}:{self.eigenpairs}:v{SPECTRUM_VERSION}"


class SpectrumParameters(Protocol):
    """Parameters of a job that determine the spectra of its shapes."""

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed."""

    @property
    def largest_component(self) -> bool:
        """Whether only the largest of several components is used."""

    @property
    def simplify(self) -> int | None:
        """Vertices to which larger shapes are simplified; None for none."""


def spectrum_key(parameters: SpectrumParameters, shape: ShapeRecord) -> SpectrumKey:
    """Return the key of a shape's spectrum.

    Parameters
    ----------
    parameters
        Parameters of the job.
    shape
        The shape.
    """
    largest = parameters.largest_component and shape.components > 1
    smaller = parameters.simplify is not None and shape.vertices > parameters.simplify
    simplify = parameters.simplify if smaller else None
    return SpectrumKey(shape.id, parameters.spectrum_size, largest, simplify, shape.file_type)
