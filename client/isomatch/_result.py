"""What all results have in common: the document they are read from."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Self

from pydantic import PrivateAttr

from isomatch._geometry import Geometry
from isomatch._models import Answer
from isomatch._plotting import saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class GeometrySource:
    """Where the surfaces of shapes can be had; it does not make one result another."""

    ask: Callable[[str], Geometry] | None = field(default=None, compare=False)


class Result(Answer):
    """A result document of the service, with its contents as typed values."""

    _document: bytes | None = PrivateAttr(default=None)
    _geometries: GeometrySource = PrivateAttr(default=GeometrySource())

    @classmethod
    def from_json(cls, document: bytes | str) -> Self:
        """Read a result document, as the service answers it or :meth:`save` wrote it.

        Raises
        ------
        pydantic.ValidationError
            It is not a result document.
        """
        result = cls.model_validate_json(document)
        result._document = document.encode() if isinstance(document, str) else document
        return result

    def to_json(self) -> bytes:
        """Return the result document exactly as the service sent it."""
        return self._document or self.model_dump_json().encode()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result document to a file, exactly as the service sent it.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        Path(path).write_bytes(self.to_json())

    def plot(self, *surfaces: Geometry, path: str | os.PathLike[str] | None = None) -> "Figure":
        """Draw the result with matplotlib, which ``pip install isomatch[plot]`` brings.

        Of a match, both shapes, matched points in common colours; of dissimilarities, a heat map.

        Parameters
        ----------
        surfaces
            The shapes that :meth:`shapes_drawn` names, as :meth:`isomatch.Client.geometry` has
            them. A result of a :class:`isomatch.Client` that is still open asks for them itself.
        path
            File to write the figure to; its ending tells the format.

        Returns
        -------
        The figure; ``matplotlib.pyplot.show()`` shows it.

        Raises
        ------
        MissingExtra
            matplotlib is not installed.
        ValueError
            Not all surfaces that are needed are given, and none can be asked for.
        OSError
            The file cannot be written.
        """
        needed = self.shapes_drawn()
        if not surfaces and self._geometries.ask is not None:
            surfaces = tuple(map(self._geometries.ask, needed))
        if len(surfaces) != len(needed):
            raise ValueError(
                f"give the {len(needed)} shapes that are drawn, as in "
                "match.plot(client.geometry(match.source), client.geometry(match.target)), "
                "or use job.plot()"
            )
        return saved(self._figure(surfaces), path)

    def shapes_drawn(self) -> tuple[str, ...]:
        """Return the ids of the shapes whose surfaces :meth:`plot` needs."""
        return ()

    def _figure(self, surfaces: Sequence[Geometry]) -> "Figure":
        raise NotImplementedError(f"there is no figure of a {type(self).__name__} yet")
