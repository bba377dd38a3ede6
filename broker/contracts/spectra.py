"""How the spectrum of a shape is named in the cache."""

from dataclasses import dataclass
from typing import Final, Protocol

SPECTRUM_VERSION: Final = 2
"""Raised whenever the solver's spectra change, so that no stale one is taken from a cache."""


@dataclass(frozen=True)
class SpectrumKey:
    """Everything a spectrum depends on: the mesh, how much of it, and the solver.

    Parameters
    ----------
    shape
        Id of the shape.
    eigenpairs
        Number of eigenpairs.
    largest_component
        Whether the spectrum is that of the shape's largest component alone.
    simplify
        Vertices to which the mesh was simplified first; None if it was not.
    """

    shape: str
    eigenpairs: int
    largest_component: bool = False
    simplify: int | None = None

    @property
    def mesh_name(self) -> str:
        """Name of the simplified mesh."""
        return f"{self._part}:mesh:v{SPECTRUM_VERSION}"

    @property
    def _part(self) -> str:
        part = "largest" if self.largest_component else "whole"
        detail = "full" if self.simplify is None else str(self.simplify)
        return f"{self.shape}:{part}:{detail}"

    def __str__(self) -> str:
        return f"{self._part}:{self.eigenpairs}:v{SPECTRUM_VERSION}"


class Endowing(Protocol):
    """Parameters that say what is measured of which part of a shape."""

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed."""

    @property
    def largest_component(self) -> bool:
        """Whether the largest of several components is meant."""

    @property
    def simplify(self) -> int | None:
        """Vertices to which a shape that has more is simplified first; None for all."""


def spectrum_key(asked: Endowing, shape: str, vertices: int, components: int) -> SpectrumKey:
    """Return the name of the spectrum that is needed of a shape.

    Parameters
    ----------
    asked
        What is measured.
    shape
        Id of the shape.
    vertices, components
        Their numbers.
    """
    largest = asked.largest_component and components > 1
    fewer = asked.simplify is not None and vertices > asked.simplify
    return SpectrumKey(shape, asked.spectrum_size, largest, asked.simplify if fewer else None)
