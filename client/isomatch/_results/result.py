"""What all results have in common: the document they are read from."""

import os
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Self, TypeAlias

from pydantic import PrivateAttr

from isomatch._models import Answer
from isomatch._results.geometry import Geometry
from isomatch._results.plotting import saved
from isomatch._results.prototype_points import PrototypePoints

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Drawable: TypeAlias = Geometry | PrototypePoints
"""A shape, or a prototype, as it is drawn."""


def is_prototype(given: str) -> bool:
    """Whether an id is that of a prototype."""
    return given.startswith("p-")


@dataclass(frozen=True)
class GeometrySource:
    """Where what is drawn can be had, by its id; it does not make one result another."""

    ask: Callable[[str], Drawable] | None = field(default=None, compare=False)


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

    def plot(
        self,
        *drawn: Drawable,
        path: str | os.PathLike[str] | None = None,
        alternative: int | None = None,
    ) -> "Figure":
        """Draw the result with matplotlib, which ``pip install isomatch[plot]`` brings.

        Of a match, both shapes, matched points in common colours; with a dense map each vertex of
        the source has the colour of the target's vertex it goes to. Of dissimilarities, a heat
        map. Of a prototype, its points and how much their distances vary.

        Parameters
        ----------
        drawn
            What :meth:`drawn_ids` names: shapes as :meth:`isomatch.Client.geometry` has them, and
            prototypes as :meth:`isomatch.Client.prototype_points` has. A result of a
            :class:`isomatch.Client` that is still open asks for them itself; so does one of an
            :class:`isomatch.AsyncClient` with no `transport` of its own, while the event loop
            waits, as it does not in ``await job.plot()``.
        path
            File to write the figure to; its ending tells the format.
        alternative
            Which answer of a match is drawn: 0 for its own pairs, j for ``alternatives[j - 1]``,
            with a refinement or a dense map only if these were made of it; None for the one that
            was refined or extended, or else its own.

        Returns
        -------
        The figure; ``matplotlib.pyplot.show()`` shows it.

        Raises
        ------
        MissingExtra
            matplotlib is not installed.
        TypeError
            The file is given without its name, `path`.
        ValueError
            Not all that is needed is given, and it cannot be asked for; or there is no such
            alternative.
        OSError
            The file cannot be written.
        """
        if any(isinstance(one, str | os.PathLike) for one in drawn):
            raise TypeError("give the file by name, as in result.plot(path='figure.png')")
        if alternative is not None:
            self._check_alternative(alternative)
        needed = self.drawn_ids()
        if not drawn and self._geometries.ask is not None:
            drawn = tuple(map(self._geometries.ask, needed))
        if [isinstance(one, PrototypePoints) for one in drawn] != list(map(is_prototype, needed)):
            raise ValueError(f"give what is drawn, as in {_call(needed)}, or use job.plot()")
        return saved(self._figure(drawn, alternative), path)

    def drawn_ids(self) -> tuple[str, ...]:
        """Return the ids of the shapes, and of the prototype, that :meth:`plot` needs."""
        return ()

    def _check_alternative(self, alternative: int) -> None:
        raise ValueError("only matches have alternatives; leave `alternative` out")

    @abstractmethod
    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        """Draw the result and what :meth:`drawn_ids` names, in that order."""


def _call(needed: Sequence[str]) -> str:
    asked = (
        f"client.{'prototype_points' if is_prototype(one) else 'geometry'}({one!r})"
        for one in needed
    )
    return f"result.plot({', '.join(asked)})"
