"""Results of transfers by the service."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pydantic import FiniteFloat

from isomatch._models import AttributeSummary, Confidence, SurfacePoint, TransferredLandmark
from isomatch._results.result_document import Drawable, Result

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


class Transfer(Result):
    """Attributes or landmarks that were carried from one shape of a match to the other.

    The values are in the files of the job: :meth:`isomatch.Job.save`.

    Attributes
    ----------
    version
        Version of the result format.
    match
        Id of the job that matched the shapes.
    source, target
        Ids of the shapes that values were carried from and to.
    source_name, target_name
        Their names.
    what
        Kind of what was carried.
    direction
        Direction in the match.
    on
        ``"vertices"`` or ``"faces"``: what of the file of `target` the rows are of; for ``"uv"``
        ``"corners"``, of the triangles of its surface, three after three.
    rows
        Number of rows; row i is vertex i, or face i, of the file of `target`, or a corner.
    attributes
        What was carried.
    points
        Of landmarks, their images on `target`, None where one has no partner; None for other kinds.
    landmarks
        Landmarks with their images and confidences, in the order in which they were given; None for
        other kinds, and in results of earlier versions.
    confidence
        :class:`Confidence` of the match that it was carried along; None if it is not known.
    warnings
        Remarks of the service on this result.
    timings
        Seconds, ``"total"``.
    """

    version: int = 1
    match: str
    source: str
    target: str
    source_name: str | None
    target_name: str | None
    what: str
    direction: str
    on: str = "vertices"
    rows: int
    attributes: tuple[AttributeSummary, ...]
    points: tuple[SurfacePoint | None, ...] | None
    landmarks: tuple[TransferredLandmark, ...] | None = None
    confidence: Confidence | None = None
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        if self.points is not None:
            return f"<Transfer of {len(self.points)} landmarks>"
        names = ", ".join(one.name for one in self.attributes)
        return f"<Transfer of {self.what} ({names}) to {self.rows} {self.on}>"

    __str__ = __repr__

    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        raise ValueError("a transfer has no figure; save it as PLY or GLB")
