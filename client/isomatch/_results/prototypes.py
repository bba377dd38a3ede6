"""Prototypes of classes of shapes, and results of learning one."""

from collections.abc import Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

from pydantic import FiniteFloat

from isomatch._models import UPRIGHT, Answer, PrototypeParameters, ViewAxes
from isomatch._results.prototype_points import PrototypePoints
from isomatch._results.result_document import Drawable, Result

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


class Example(Answer):
    """Use of one example in the learning of a prototype.

    Attributes
    ----------
    shape
        Id of the shape.
    used
        Whether the prototype was learned from it.
    misfit
        Energy of its match with a preliminary prototype of all examples; 0 with given
        correspondences.
    reason
        Reason for leaving it out; None if it was used.
    """

    shape: str
    used: bool
    misfit: FiniteFloat
    reason: str | None


class Prototype(Answer):
    """A prototype: distributions of descriptors and distances of points of a class of shapes.

    Attributes
    ----------
    id
        Content hash of the archive: the same bytes have the same id.
    name, version
        Name of the prototype, and its version of that name, from 1.
    bytes
        Size of the archive.
    points
        Number of its points.
    components
        Greatest number of Gaussians of a mixture.
    examples
        Number of shapes that it was learned from.
    parameters
        Structures of shapes that are matched with it: ``"metric"``, ``"descriptor"``,
        ``"sampling"``, ``"eigenpairs"``, ``"geodesic_method"`` and ``"normalise"``.
    surfaces
        Number of example surfaces that it contains, for orientation.
    learned_from
        Use of each example; None if the prototype was uploaded.
    reference
        Id of the shape on which its points were sampled; None if the prototype was uploaded.
    view
        Directions to the right, up and towards the viewer in figures: rows of a rotation.
    warnings
        Remarks of the service on the prototype.
    created
        Time of learning or upload.
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
    view: ViewAxes = UPRIGHT
    warnings: tuple[str, ...]
    created: datetime


class LearnedPrototype(Result):
    """Result of learning a prototype.

    Attributes
    ----------
    version
        Version of the result format.
    prototype
        The prototype.
    parameters
        Parameters of the job, with defaults filled in.
    warnings
        Remarks of the service on this result.
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
