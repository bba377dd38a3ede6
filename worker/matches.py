"""A match: two meshes and their spectra in, the result document out."""

import gzip
from dataclasses import dataclass, fields
from typing import Any

from solver.control import Control
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh
from solver.shape import Shape
from solver.spectrum import Spectrum
from worker.contracts import MatchParameters, MatchPayload, MatchResult


@dataclass(frozen=True)
class Side:
    """One of the two shapes of a match.

    Parameters
    ----------
    mesh
        The connected mesh that is matched.
    spectrum
        Its spectrum on unit area; None if no structure that is compared needs one.
    """

    mesh: TriangleMesh
    spectrum: Spectrum | None


def options_of(parameters: MatchParameters) -> MatchOptions:
    """Return the solver's options, which have the same names.

    Parameters
    ----------
    parameters
        What was asked; some of it is not for the solver's options but for how shapes are made.
    """
    values: dict[str, Any] = parameters.model_dump()
    values |= {"metric": parameters.metrics, "descriptor": parameters.descriptors}
    return MatchOptions(**{field.name: values[field.name] for field in fields(MatchOptions)})


def result_from_blob(packed: bytes) -> MatchResult:
    """Read a stored result."""
    return MatchResult.model_validate_json(gzip.decompress(packed))
