"""Failures of jobs.

::

    Gone                a shape, upload, prototype, attribute file or result expired or was deleted
    └── ShapeLost       the blob store has lost the content of a shape
    UnusableShape       one of several shapes cannot be used
    TooLarge            a shape needs more memory than a job may take
    TimeUp              the job's time was up before it had any part of its result
    NotDelivered        a webhook's receiver did not accept it

    JobTimedOut         the job took longer than it may; no Exception
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import ClassVar, Final

from broker.blobs import BlobLost
from broker.contracts import FieldProblem, ProblemType
from broker.store import Store
from solver.errors import MeshError


class Gone(Exception):
    """Data that a job needs expired or was deleted before the job ran."""

    type: ClassVar[ProblemType]


class ShapeGone(Gone):
    """A shape was deleted or expired before the job ran.

    Parameters
    ----------
    shape
        Id of the shape.
    """

    type = ProblemType.SHAPE_DELETED

    def __init__(self, shape: str) -> None:
        super().__init__(f"shape {shape} was deleted, or expired, before this job could run")


class ShapeLost(Gone):
    """The blob store has lost the content of a shape.

    Parameters
    ----------
    shape
        Id of the shape.
    reason
        What is wrong with it, as :class:`~broker.blobs.BlobLost` has it.
    """

    type = ProblemType.CONTENT_LOST

    def __init__(self, shape: str, reason: str) -> None:
        lost = f"the stored content of shape {shape} is {reason}"
        super().__init__(f"{lost}; delete it, and upload it again")


class UploadGone(Gone):
    """An upload expired before the job that validates it ran."""

    type = ProblemType.UPLOAD_EXPIRED

    def __init__(self) -> None:
        super().__init__("The upload waited for too long to be read; send it again.")


class PrototypeGone(Gone):
    """A prototype was deleted or expired before the job ran.

    Parameters
    ----------
    prototype
        Id of the prototype.
    """

    type = ProblemType.PROTOTYPE_DELETED

    def __init__(self, prototype: str) -> None:
        gone = f"prototype {prototype} was deleted, or expired,"
        super().__init__(f"{gone} before this job could run")


class AttributesGone(Gone):
    """An attribute file was deleted or expired before the job ran.

    Parameters
    ----------
    attributes
        Id of the file.
    """

    type = ProblemType.ATTRIBUTES_DELETED

    def __init__(self, attributes: str) -> None:
        gone = f"attribute file {attributes} was deleted, or expired,"
        super().__init__(f"{gone} before this job could run")


class ResultGone(Gone):
    """The result to be drawn, or the match to be carried along, has expired."""

    type = ProblemType.RESULT_EXPIRED


class UnusableShape(Exception):
    """One of several shapes cannot be used.

    Parameters
    ----------
    field
        Field of the request that names the shape.
    reason
        What is wrong with it.
    """

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"{field}: {reason}")
        self.field = FieldProblem(field=f"body.{field}", message=reason)


@contextmanager
def attributed_to(field: str) -> Iterator[None]:
    """Attribute mesh errors to a field of the request.

    Parameters
    ----------
    field
        Field that names the shape.

    Raises
    ------
    UnusableShape
        For any :class:`MeshError` inside.
    """
    try:
        yield
    except MeshError as error:
        raise UnusableShape(field, str(error)) from error


@contextmanager
def content_of(shape: str) -> Iterator[None]:
    """Name the shape whose content is read.

    Parameters
    ----------
    shape
        Id of the shape.

    Raises
    ------
    ShapeLost
        For any :class:`~broker.blobs.BlobLost` inside.
    """
    try:
        yield
    except BlobLost as error:
        raise ShapeLost(shape, error.reason) from error


def none_usable(
    shapes: Sequence[str], reasons: Sequence[str | None], store: Store
) -> ShapeGone | UnusableShape:
    """Return why a job of several shapes has none left: one that is gone, or the first reason.

    Parameters
    ----------
    shapes
        Ids, as `shapes` of the request has them.
    reasons
        Why each cannot be used, or ``None``; at least one is not.
    store
        Store of the shapes.
    """
    failed = [(place, reason) for place, reason in enumerate(reasons) if reason is not None]
    kept = store.shapes.records([shapes[place] for place, _ in failed])
    for (place, _), record in zip(failed, kept, strict=True):
        if record is None:
            return ShapeGone(shapes[place])
    place, reason = failed[0]
    return UnusableShape(f"shapes.{place}", reason)


class TooLarge(Exception):
    """A shape needs more memory than a job may take, as estimated before the computation.

    Parameters
    ----------
    vertices
        Number of vertices.
    needed, left
        Bytes.
    """

    def __init__(self, vertices: int, needed: float, left: float) -> None:
        super().__init__(
            f"The spectrum of {vertices} vertices takes {needed / 2**30:.2g} GiB of memory, and a"
            f" job has {left / 2**30:.2g} GiB left; give `simplify`, for fewer vertices."
        )


SHAPE_FAILURES: Final = (UnusableShape, ShapeGone, ShapeLost, TooLarge, MemoryError)
"""Failures of one of several shapes, without which a job of a collection goes on."""

_OUT_OF_MEMORY: Final = "this needs more memory than a job may take; simplify the mesh"


def reason_of(error: Exception) -> str:
    """Return the reason why one of several shapes failed, for the report on that shape."""
    if isinstance(error, MemoryError):
        return _OUT_OF_MEMORY
    return error.field.message if isinstance(error, UnusableShape) else str(error)


class TimeUp(Exception):
    """The time of a job was up before it had any part of its result."""


class JobTimedOut(BaseException):
    """A job took longer than it may, wherever it was.

    No :class:`Exception`: readers of damaged files take any of those for damage.
    """


class NotDelivered(Exception):
    """The receiver of a webhook did not accept it."""
