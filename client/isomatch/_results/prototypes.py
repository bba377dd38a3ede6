"""Prototypes of classes of shapes, and what comes of learning one."""

from collections.abc import Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

from pydantic import FiniteFloat

from isomatch._models import Answer, PrototypeParameters
from isomatch._results.prototype_points import PrototypePoints
from isomatch._results.result_document import Drawable, Result

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


class Example(Answer):
    """What became of one of the shapes that a prototype was to be learned from.

    Attributes
    ----------
    shape
        Id of the shape.
    used
        Whether the prototype was learned from it.
    misfit
        Energy of its match with a preliminary prototype of all; 0 where nothing had to be matched.
    reason
        Why it was not used; None if it was.
    """

    shape: str
    used: bool
    misfit: FiniteFloat
    reason: str | None


class Prototype(Answer):
    """A prototype: what the points of a class of shapes are like, and how far from one another.

    Attributes
    ----------
    id
        Content hash of the archive: the same bytes have the same id.
    name, version
        What it is called, and which of that name it is, counted from 1.
    bytes
        Size of the archive.
    points
        Number of its points.
    components
        Gaussians of a mixture, at most.
    examples
        Number of the shapes it was learned from.
    parameters
        What is measured of shapes that are compared with it: ``"metric"``, ``"descriptor"``,
        ``"sampling"``, ``"eigenpairs"``, ``"geodesic_method"`` and ``"normalise"``.
    surfaces
        Surfaces of examples that it keeps, by which left is told from right.
    learned_from
        What became of each shape it was to be learned from; None if it was uploaded.
    reference
        Id of the shape its points were chosen on; None if it was uploaded.
    warnings
        What should be known of it.
    created
        When it was learned or uploaded.
    """

    id: str
    name: str
    version: int
    bytes: int
    points: int
    components: int
    examples: int
    parameters: dict[str, Any]
    surfaces: int = 0
    learned_from: tuple[Example, ...] | None
    reference: str | None
    warnings: tuple[str, ...]
    created: datetime


class LearnedPrototype(Result):
    """What came of learning a prototype.

    Attributes
    ----------
    version
        Version of the result format.
    prototype
        The prototype, which can be matched with shapes.
    parameters
        The parameters in force, defaults filled in.
    warnings
        What the service wants known about this answer.
    timings
        Seconds by stage, and ``"total"``.
    """

    version: int = 1
    prototype: Prototype
    parameters: PrototypeParameters
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        made = self.prototype
        about = f"{made.points} points of {made.examples} examples"
        return f"<LearnedPrototype {made.name!r}, version {made.version}, {about}>"

    __str__ = __repr__

    def drawn_ids(self) -> tuple[str, ...]:
        """Return the id of the prototype."""
        return (self.prototype.id,)

    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        made, (known,) = self.prototype, drawn
        assert isinstance(known, PrototypePoints)
        about = f"{made.points} points, learned from {made.examples} examples"
        return known.plot(f"{made.name}, version {made.version}: {about}")
