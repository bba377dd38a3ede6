"""Result documents of the service, the base of every kind of result."""

import os
from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Self, TypeAlias

from pydantic import PrivateAttr

from isomatch._errors import ClientClosed
from isomatch._models import Answer, is_prototype_id
from isomatch._results.geometry import Geometry
from isomatch._results.prototype_points import PrototypePoints

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


Drawable: TypeAlias = Geometry | PrototypePoints
"""The surface of a shape, or the points of a prototype."""


@dataclass(frozen=True)
class DrawableSource:
    """Function that requests a shape or a prototype by its id; ignored when results are compared.

    Attributes
    ----------
    request
        The function; None in results of an asynchronous client, which this would block, and in
        those that were read from a file or unpickled.
    """

    request: Callable[[str], Drawable] | None = field(default=None, compare=False)

    def __reduce__(self) -> tuple[type["DrawableSource"], tuple[()]]:
        # The function holds a connection, which stays in its process.
        return DrawableSource, ()

    def __deepcopy__(self, memo: object) -> "DrawableSource":
        return self


class Result(Answer):
    """A result document of the service, with its contents as typed values.

    Attributes
    ----------
    kind, job
        Kind and id of the job; None in results of earlier versions.
    """

    kind: str | None = None
    job: str | None = None

    _document: bytes | None = PrivateAttr(default=None)
    _drawables: DrawableSource = PrivateAttr(default=DrawableSource())

    @classmethod
    def from_json(cls, document: bytes | str) -> Self:
        """Read a result document, as the service answers it or :meth:`save` writes it.

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

    def held(self, ending: str) -> bytes | None:
        """Return the file of a format, such as "json", if it needs no request."""
        return self.to_json() if ending == "json" else None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file without a request, in the format that its name ends in.

        ``.json``, or no ending, is the document, exactly as the service sent it. Registrations and
        consistent maps that were not read from a file have their arrays, too, ``.npz``.

        Raises
        ------
        OSError, ValueError
            The file cannot be written, or its name has another ending: :meth:`isomatch.Job.save`
            requests other formats.
        """
        ending = Path(path).suffix
        content = self.held(ending.lower().removeprefix(".") or "json")
        if content is None:
            raise ValueError(f"the result is not held as {ending}: give .json, or use job.save()")
        Path(path).write_bytes(content)

    def plot(self, *drawn: Drawable, alternative: int | None = None) -> "Figure":
        """Draw the result as an interactive plotly figure (``pip install isomatch[plot]``).

        A match shows both shapes with corresponding points in common colours; with a dense map,
        each vertex of the source has the colour of its target vertex. Dissimilarities are a heat
        map. A prototype shows its points and the variation of their distances.

        The figure is shown by a notebook or by ``figure.show()``; ``figure.write_html(path)``
        writes it to a file. :meth:`isomatch.Job.save_picture` has a PNG from the service.

        Parameters
        ----------
        drawn
            The shapes and the prototype that :meth:`drawn_ids` names, from
            :meth:`isomatch.Client.geometry` and :meth:`isomatch.Client.prototype_points`. By
            default they are requested from the service, while the client is open. Give them for a
            result that was read from a file, unpickled, or requested by an
            :class:`isomatch.AsyncClient`, of which ``await job.plot()`` requests them.
        alternative
            Solution of a match: 0 for its own pairs, j for ``alternatives[j - 1]``. By default
            the one that was refined or densely extended, or else 0.

        Raises
        ------
        MissingExtra
            plotly is not installed.
        ValueError
            `drawn` does not fit the result and cannot be requested, or there is no such
            alternative.
        """
        if alternative is not None:
            self._check_alternative(alternative)
        needed = self.drawn_ids()
        if not drawn and self._drawables.request is not None:
            with suppress(ClientClosed):
                drawn = tuple(map(self._drawables.request, needed))
        if [isinstance(one, PrototypePoints) for one in drawn] != list(
            map(is_prototype_id, needed)
        ):
            raise ValueError(f"give what is drawn, as in {_call(needed)}, or use job.plot()")
        return self._figure(drawn, alternative)

    def drawn_ids(self) -> tuple[str, ...]:
        """Return the ids of the shapes and the prototype that :meth:`plot` needs."""
        return ()

    def _check_alternative(self, alternative: int) -> None:
        raise ValueError("only matches have alternatives; leave `alternative` out")

    @abstractmethod
    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        """Draw the result with what :meth:`drawn_ids` names, in that order."""


def _call(needed: Sequence[str]) -> str:
    requests = (
        f"client.{'prototype_points' if is_prototype_id(one) else 'geometry'}({one!r})"
        for one in needed
    )
    return f"result.plot({', '.join(requests)})"
