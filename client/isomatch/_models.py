"""What the service answers, as typed values.

Fields this version does not know are left aside, so that a newer service can be spoken to; fields
that are missing, or numbers that are not finite, are errors.
"""

from datetime import datetime
from functools import cached_property
from typing import Generic, Literal, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, FiniteFloat

from isomatch._problem import Problem

JobState: TypeAlias = Literal["queued", "running", "succeeded", "failed", "cancelled"]

ItemT = TypeVar("ItemT")


class Answer(BaseModel):
    """Anything the service answers: unchangeable, and open to fields of newer services."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class Shape(Answer):
    """An uploaded shape.

    Attributes
    ----------
    id
        Content hash: the same bytes have the same id.
    name
        The name given at upload, or the name of the file.
    file_type
        Mesh format, such as ``"off"``.
    bytes
        Size of the uploaded file.
    vertices, faces
        Their numbers, after repair.
    area
        Surface area, in the square of the file's unit of length.
    components
        Number of connected components.
    closed
        Whether the surface has no boundary.
    has_colors
        Whether the vertices have colours.
    warnings
        What was repaired.
    created
        When it was uploaded.
    """

    id: str
    name: str
    file_type: str
    bytes: int
    vertices: int
    faces: int
    area: FiniteFloat
    components: int
    closed: bool
    has_colors: bool
    warnings: tuple[str, ...]
    created: datetime


class Invariance(Answer):
    """To what a structure is invariant, if shapes are not normalised: a row of Table 1.

    Attributes
    ----------
    bending, topology, scale
        Deformations that keep lengths on the surface; holes and glued points; scaling: ``"yes"``,
        ``"approx"`` or ``"no"``.
    """

    bending: str
    topology: str
    scale: str


class StructureParameter(Answer):
    """A parameter of a structure.

    Attributes
    ----------
    name, description
        What it is called, and what it is.
    type
        ``"number"``, ``"integer"``, or ``"numbers"`` for a list.
    default
        What it is when left out; of what has a unit, on a surface of unit area.
    minimum, maximum
        Its range, ends included.
    unit
        ``"length"``, ``"area"``, or nothing.
    """

    name: str
    description: str
    type: str
    default: int | FiniteFloat | tuple[FiniteFloat, ...]
    minimum: int | FiniteFloat
    maximum: int | FiniteFloat
    unit: str


class Structure(Answer):
    """A metric or a descriptor that can be chosen.

    Attributes
    ----------
    name
        What it is chosen by.
    description, formula, source
        What it is, and where it is from.
    unit
        Of its values, in powers of length; ``"1"`` if they have none.
    invariance, remarks
        What does not change it, and what else must be known of that.
    spectral
        Whether it is made of Laplace-Beltrami eigenpairs.
    needs_colors
        Whether the shapes must have vertex colours.
    parameters
        What can be given beside its name.
    """

    name: str
    description: str
    formula: str
    source: str
    unit: str
    invariance: Invariance
    remarks: str
    spectral: bool
    needs_colors: bool
    parameters: tuple[StructureParameter, ...]


class Structures(Answer):
    """What can be compared of shapes.

    Attributes
    ----------
    metrics, descriptors
        Global and local structures.
    """

    metrics: tuple[Structure, ...]
    descriptors: tuple[Structure, ...]


class Progress(Answer):
    """How far a job is.

    Attributes
    ----------
    stage
        What is being done.
    fraction
        Share of the whole job that is done, 0 to 1.
    """

    stage: str
    fraction: FiniteFloat


class JobWebhook(Answer):
    """Whom the end of a job is told to, and how that went.

    Attributes
    ----------
    url
        The receiver's address, without its query.
    state
        ``"pending"``, ``"delivered"``, or ``"failed"`` after the last attempt.
    attempts, last_attempt, next_attempt
        How often and when it was tried last, and when it is tried again.
    status, error
        HTTP status the receiver answered with last, and what went wrong.
    """

    url: str
    state: Literal["pending", "delivered", "failed"]
    attempts: int
    last_attempt: datetime | None
    status: int | None
    error: str | None
    next_attempt: datetime | None


class JobRecord(Answer):
    """A job as the service last described it; :class:`isomatch.Job` says what the fields mean."""

    id: str
    kind: str
    state: JobState
    source: str | None = None
    target: str | None = None
    shapes: tuple[str, ...] = ()
    shape_count: int = 0
    prototype: str | None = None
    name: str | None = None
    progress: Progress
    created: datetime
    started: datetime | None
    ended: datetime | None
    position: int | None
    error: Problem | None
    caller: str | None
    webhook: JobWebhook | None

    @property
    def finished(self) -> bool:
        """Whether the job has ended, in whatever way."""
        return self.state in ("succeeded", "failed", "cancelled")


class Page(Answer, Generic[ItemT]):
    """One page of a listing, and the cursor of the next."""

    items: tuple[ItemT, ...]
    next_cursor: str | None


class Correspondence(Answer):
    """One matched pair of vertices.

    Attributes
    ----------
    source, target
        0-based vertex indices in the uploaded files; of a prototype, numbers of its points.
    cost
        What the pair contributes to the energy.
    """

    source: int
    target: int
    cost: FiniteFloat


class Distortion(Answer):
    """Distortion of a correspondence, section 2 of the paper; lengths on shapes of unit area.

    Attributes
    ----------
    first_order
        Sum of squared differences of descriptors over the pairs; None without a descriptor.
    second_order
        Sum of squared differences of distances over all pairs of pairs.
    linf
        Largest difference of distances.
    """

    first_order: FiniteFloat | None
    second_order: FiniteFloat
    linf: FiniteFloat


class Correspondences(Answer):
    """Matched pairs with their energy and distortion, and the same as arrays."""

    energy: FiniteFloat
    correspondences: tuple[Correspondence, ...]
    distortion: Distortion

    @cached_property
    def pairs(self) -> npt.NDArray[np.int64]:
        """Matched vertex indices, source and target, shape (n, 2), int64."""
        rows = [(pair.source, pair.target) for pair in self.correspondences]
        return np.array(rows, dtype=np.int64).reshape(-1, 2)

    @cached_property
    def costs(self) -> npt.NDArray[np.float64]:
        """What each pair contributes to the energy, shape (n,), float64."""
        return np.array([pair.cost for pair in self.correspondences], dtype=np.float64)


class Alternative(Correspondences):
    """Another good correspondence, often the mirror image of the best.

    Attributes
    ----------
    energy
        Energy of the labelling problem, (5) of the paper.
    correspondences
        The matched pairs.
    distortion
        Their distortion.
    """


class Level(Answer):
    """One level of the coarse-to-fine matching, section 4.1 of the paper.

    Attributes
    ----------
    points, target_points
        Samples on the source and on the target.
    candidates
        Pairs that were considered.
    metric, descriptor
        Names of the structures that were compared.
    energy, lower_bound, gap, certified, iterations, method, seconds
        The answer of the solver, what it proved, and what it took.
    rank
        Place of this answer among all hypotheses by their energy at this level, 1 for the first.
    """

    points: int
    target_points: int
    candidates: int
    metric: str
    descriptor: str
    energy: FiniteFloat
    lower_bound: FiniteFloat
    gap: FiniteFloat
    certified: bool
    iterations: int
    method: str
    seconds: FiniteFloat
    rank: int
