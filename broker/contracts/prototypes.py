"""Prototypes of classes of shapes: how they are learned, and what is known of each."""

import hashlib
from datetime import datetime
from typing import Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.descriptors import DescriptorByLevel, descriptor_choices
from broker.contracts.metrics import MetricByLevel, metric_choices
from broker.contracts.parameters import GeodesicMethod
from broker.contracts.structures import Choice

MOST_EXAMPLES: Final = 256
"""Shapes that a prototype is learned from at most."""

PROTOTYPE_PREFIX: Final = "p-"
"""How ids of prototypes begin, which tells them from those of shapes."""

ARCHIVE_TYPE: Final = "npz"

CorrespondenceSource: TypeAlias = Literal["matches", "shared_connectivity"]


def prototype_id(archive: bytes) -> str:
    """Return the id of a prototype: its prefix, and 32 hexadecimal digits of a SHA-256."""
    return PROTOTYPE_PREFIX + hashlib.sha256(archive).hexdigest()[:32]


def is_prototype(source: str) -> bool:
    """Whether an id is that of a prototype."""
    return source.startswith(PROTOTYPE_PREFIX)


class PrototypeStructures(BaseModel):
    """What is measured of shapes that are compared with a prototype."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    metric: MetricByLevel = Field(
        default="geodesic",
        description="Distance of every two points, whose distribution is learned: a metric for all"
        " levels of a match, or one for each from the coarsest on, of which the last is repeated. A"
        " metric is its name, or an object of its name and its parameters; `GET /v1/structures`"
        " lists them.",
        examples=["geodesic", {"name": "diffusion", "time": 0.02}, ["commute_time", "geodesic"]],
    )
    descriptor: DescriptorByLevel = Field(
        default="si_hks",
        description='Local descriptor of every point, given like `metric`; "none" for distances'
        " alone. Eigenfunctions have no signs that shapes have in common, and cannot be learned.",
        examples=["none", "hks"],
    )
    sampling: MetricByLevel = Field(
        default=("commute_time", "geodesic"),
        description="Metrics, given like `metric`, in which points of a shape are sampled, farthest"
        " first and by turns; those of the prototype are sampled on the reference in the first.",
    )
    eigenpairs: int = Field(
        default=100,
        ge=10,
        le=300,
        description="Eigenpairs of the Laplace-Beltrami operator.",
    )
    geodesic_method: GeodesicMethod = Field(
        default="fast_marching",
        description="How geodesic distances are computed, as for a match.",
    )
    normalise: bool = Field(
        default=True,
        description="Scale all shapes to unit area first. If false, sizes belong to the class.",
    )

    @property
    def metrics(self) -> tuple[Choice, ...]:
        """The metrics by level, coarsest first; the last holds for all further levels."""
        return metric_choices(self.metric)

    @property
    def descriptors(self) -> tuple[Choice, ...]:
        """The descriptors by level, coarsest first; the last holds for all further levels."""
        return descriptor_choices(self.descriptor)

    @property
    def samplings(self) -> tuple[Choice, ...]:
        """The metrics in which points are sampled."""
        return metric_choices(self.sampling)

    @property
    def spectral(self) -> bool:
        """Whether Laplace-Beltrami eigenpairs are looked at, be it to sample points."""
        choices = (*self.metrics, *self.descriptors, *self.samplings)
        return any(choice.about.spectral for choice in choices)


class PrototypeParameters(PrototypeStructures):
    """How a prototype is learned; everything has a default that is meant to be good.

    Section and equation numbers are those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.
    """

    points: int = Field(
        default=32,
        ge=3,
        le=256,
        description="Points of the prototype. Of those in `correspondences` so many are taken, the"
        " farthest from one another; all of them if this is left out.",
    )
    components: int = Field(
        default=5,
        ge=1,
        le=16,
        description="Gaussians of each mixture, K of section 6.4: no more than half the number of"
        " examples are used.",
    )
    select_components: bool = Field(
        default=False,
        description="Choose the number of Gaussians by the Bayesian information criterion, up to"
        " `components`.",
    )
    correspondence: CorrespondenceSource = Field(
        default="matches",
        description='Which points of the shapes correspond: "matches" has the reference matched to'
        ' every other shape; "shared_connectivity" takes the same vertex of every file, which'
        " must all have the same faces. It is not looked at where `correspondences` are given.",
    )
    simplify: int | None = Field(
        default=None,
        ge=100,
        le=1_000_000,
        description="Vertices to which a shape that has more is simplified first; null for no"
        ' simplification. Only with `correspondence` "matches".',
    )
    seed: int = Field(
        default=0,
        ge=0,
        le=2**31 - 1,
        description="Of what is random in learning; the same seed, the same prototype.",
    )

    @property
    def needs_spectrum(self) -> bool:
        """Whether learning looks at the spectrum of the shapes, be it to match them."""
        return self.spectral or self.correspondence == "matches"

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed of each shape."""
        return self.eigenpairs

    @property
    def largest_component(self) -> bool:
        """Whether the largest of several components is meant: examples must have one."""
        return False


class ExampleReport(BaseModel):
    """What became of one of the shapes that a prototype was to be learned from."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    shape: str = Field(description="Id of the shape.")
    used: bool = Field(description="Whether the prototype was learned from it.")
    misfit: float = Field(
        description="Energy of its match with a preliminary prototype; 0 where nothing had to be"
        " matched."
    )
    reason: str | None = Field(description="Why it was not used; null if it was.")


class PrototypeRecord(BaseModel):
    """A prototype: what the points of a class of shapes are like, and how far from one another."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "id": "p-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                    "name": "human",
                    "version": 2,
                    "bytes": 12874,
                    "points": 32,
                    "components": 5,
                    "examples": 64,
                    "parameters": {
                        "metric": [{"name": "geodesic"}],
                        "descriptor": [{"name": "si_hks", "frequencies": 6}],
                        "sampling": [{"name": "commute_time"}, {"name": "geodesic"}],
                        "eigenpairs": 100,
                        "geodesic_method": "fast_marching",
                        "normalise": True,
                    },
                    "surfaces": 24,
                    "learned_from": None,
                    "reference": None,
                    "warnings": [],
                    "created": "2026-03-01T12:00:00Z",
                }
            ]
        },
    )

    id: str = Field(description="Content hash of the archive: the same bytes have the same id.")
    name: str = Field(description="The name it was learned or uploaded under.")
    version: int = Field(
        ge=1, description="Which prototype of this name it is, counted from 1; it never changes."
    )
    bytes: int = Field(description="Size of the archive.")
    points: int = Field(description="Number N of its points.")
    components: int = Field(description="Gaussians of a mixture, at most.")
    examples: int = Field(description="Number M of the shapes it was learned from.")
    parameters: PrototypeStructures = Field(
        description="What is measured of shapes that are compared with it."
    )
    surfaces: int = Field(
        default=0,
        description="Surfaces of examples that it keeps, by which left is told from right; 0 for an"
        " archive that has none.",
    )
    learned_from: tuple[ExampleReport, ...] | None = Field(
        description="What became of each shape it was to be learned from; null if it was uploaded."
    )
    reference: str | None = Field(
        description="Id of the shape its points were chosen on; null if it was uploaded."
    )
    warnings: tuple[str, ...] = Field(description="What should be known of it.")
    created: datetime = Field(description="When it was learned or uploaded.")


class PrototypeSurface(BaseModel):
    """The simplified surface of an example of a prototype, and the prototype's points on it."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    positions: tuple[tuple[float, float, float], ...] = Field(
        description="Positions of the vertices relative to the middle of the surface, scaled so"
        " that its largest extent is from -1 to 1."
    )
    faces: tuple[tuple[int, int, int], ...] = Field(
        description="Corners of the triangles, as indices of positions."
    )
    points: tuple[int, ...] = Field(
        description="Index of the position at or nearest to each point of the prototype."
    )


class PrototypeGeometry(BaseModel):
    """Where the points of a prototype lie, for drawing."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "vertices": [17, 204, 31],
                    "surface": {
                        "positions": [[-1, 0, 0], [0, 1, 0], [1, 0, 0]],
                        "faces": [[0, 1, 2]],
                        "points": [0, 1, 2],
                    },
                }
            ]
        },
    )

    vertices: tuple[int, ...] = Field(
        description="0-based vertex index of each point in the file of the reference shape."
    )
    surface: PrototypeSurface | None = Field(
        description="A surface to draw the points on; null for a prototype that keeps none."
    )


class PrototypeResult(BaseModel):
    """What came of learning a prototype."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    version: Literal[1] = Field(default=1, description="Version of this format.")
    prototype: PrototypeRecord
    parameters: PrototypeParameters = Field(description="The parameters in force.")
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(description='Seconds by stage, and "total".')
