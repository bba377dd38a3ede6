"""The parameters of a match, under the names the solver gives them."""

from typing import Annotated, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from broker.contracts.descriptors import DescriptorByLevel, descriptor_choices
from broker.contracts.metrics import MetricByLevel, metric_choices
from broker.contracts.structures import Choice

ObjectiveName: TypeAlias = Literal["l2", "linf"]
RefinementName: TypeAlias = Literal["gmds"]
GeodesicMethod: TypeAlias = Literal["graph", "fast_marching", "heat"]

Vertex: TypeAlias = Annotated[int, Field(ge=0, le=2**53, strict=True)]
Landmark: TypeAlias = Annotated[tuple[Vertex, ...], Field(min_length=2, max_length=2, strict=False)]
"""A vertex of the source's file and one of the target's."""

DENSE_EIGENPAIRS: Final = 100
"""Eigenpairs of dense maps, which refinements begin with too."""


class MatchParameters(BaseModel):
    """How two shapes are matched; everything has a default that is meant to be good.

    Section and equation numbers are those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.
    Distances are taken on shapes of unit area unless `normalise` is false.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    points: int = Field(
        default=32, ge=3, le=256, description="Points of the source matched at the finest level."
    )
    coarse_points: int = Field(
        default=8,
        ge=3,
        le=10,
        description="Points of the coarsest level, which is solved to proven optimality: N_1 of"
        " section 4.1.",
    )
    level_factor: int = Field(
        default=2,
        ge=2,
        le=4,
        description="How many times more points each level has than the one before: q of"
        " section 4.1.",
    )
    oversampling: int = Field(
        default=4,
        ge=1,
        le=8,
        description="Target samples for each source sample on the finer levels.",
    )
    rho: float = Field(
        default=1.5,
        gt=1,
        le=4,
        description="Radius of the neighbourhood in which a match may move from one level to the"
        " next, in covering radii of the level: section 4.1.",
    )
    metric: MetricByLevel = Field(
        default=("commute_time", "geodesic"),
        description="Distance to be preserved: a metric for all levels, or one for each from the"
        " coarsest on, of which the last is repeated. A metric is its name, or an object of its"
        " name and its parameters; `GET /v1/structures` lists them. Between commute times and"
        " geodesic distances the coarsest level's points are matched a second time, by heat.",
        examples=["geodesic", {"name": "diffusion", "time": 0.02}, ["commute_time", "geodesic"]],
    )
    descriptor: DescriptorByLevel = Field(
        default="si_hks",
        description='Local descriptor to be preserved, given like `metric`; "none" switches the'
        " first-order term off.",
        examples=["none", {"name": "si_hks", "frequencies": 8}, ["si_hks", "hks"]],
    )
    beta: float = Field(
        default=1.0,
        ge=0,
        le=1e6,
        description="Weight of the second-order (metric) term, equation (5).",
    )
    first_order_weight: float = Field(
        default=0.05, ge=0, le=1e6, description="Weight of the first-order (descriptor) term."
    )
    occlusion_cost: float | None = Field(
        default=None,
        gt=0,
        le=1e9,
        description="Cost of leaving a source point unmatched, gamma of (5); null makes it large"
        " enough that every point is matched.",
    )
    eigenpairs: int = Field(
        default=100,
        ge=10,
        le=300,
        description="Eigenpairs of the Laplace-Beltrami operator.",
    )
    geodesic_method: GeodesicMethod = Field(
        default="fast_marching",
        description='How geodesic distances are computed: "fast_marching" errs by some 0.2 %;'
        ' "graph", shortest paths over edges, by 2 %, in half the time; "heat" gives smooth ones,'
        " at 1 to 5 %.",
    )
    alternatives: int = Field(
        default=8,
        ge=1,
        le=32,
        description="How many of the best solutions of the coarse level are kept and refined.",
    )
    objective: ObjectiveName = Field(
        default="l2",
        description='What is minimised: "l2", the energy (5), or "linf", the greatest distortion of'
        " a distance, half of which is the Gromov-Hausdorff distance of the matched samples."
        ' "linf" is solved exactly, on one level: it takes at most 10 points, and matches all.',
    )
    refine: RefinementName | None = Field(
        default=None,
        description='"gmds" to find where the matched points lie on the target between its'
        " vertices, by generalized multidimensional scaling, section 7.1: `refinement` of the"
        " result; null not to.",
    )
    orientation: bool = Field(
        default=False,
        description="Whether to tell left from right: the answer is the hypothesis whose extension"
        " to all vertices preserves most and keeps orientation, rather than the likeliest by"
        " distances, of which the mirror image is as good; alternatives may then have less energy."
        " Takes some seconds. `dense` and `refine` include it. Surfaces must be wound alike, as"
        " closed ones are after repair. With a prototype that keeps surfaces of its examples the"
        " default is true, and it tells too which of the front legs goes with which of the hind"
        " legs.",
    )
    dense: bool = Field(
        default=False,
        description="Whether to extend the match to all vertices: `dense` of the result.",
    )
    landmarks: tuple[Landmark, ...] = Field(
        default=(),
        max_length=32,
        strict=False,
        description="Pairs of vertices that are known to correspond, 0-based in the files of the"
        " source and of the target. They are matched with one another, count among `points`, and"
        " decide between symmetric solutions: one on a hand tells left from right. For a"
        " vertex that repair or `simplify` has merged into another, that other stands. With"
        ' `occlusion_cost`, they too may stay unmatched. Not with objective "linf".',
        examples=[[[17, 203], [1040, 88]]],
    )
    normalise: bool = Field(
        default=True,
        description="Scale both shapes to unit area first, so that shapes of any size compare. If"
        " false, distances and the parameters of structures are in the users' unit of length, and"
        " parameters left out suit the geometric mean of both areas.",
    )
    largest_component: bool = Field(
        default=False,
        description="Match the largest component of a shape that has several, which is refused"
        " otherwise.",
    )
    simplify: int | None = Field(
        default=None,
        ge=100,
        le=1_000_000,
        description="Vertices to which a shape that has more is simplified before it is matched;"
        " null for no simplification. Points are named by vertices of the file, all of which"
        " keep their places.",
    )
    time_limit: float | None = Field(
        default=None,
        gt=0,
        le=86400,
        description="Seconds after which the best answer so far is returned with its gap; null"
        " for no limit.",
    )

    @field_validator("objective")
    @classmethod
    def _suits_the_objective(cls, value: str, info: ValidationInfo) -> str:
        if value == "linf" and info.data.get("points", 0) > 10:
            raise ValueError('"linf" takes at most 10 points; give `points`, from 3 to 10')
        if value == "linf" and info.data.get("occlusion_cost") is not None:
            raise ValueError('"linf" matches every point; leave `occlusion_cost` out')
        return value

    @field_validator("landmarks")
    @classmethod
    def _can_be(cls, value: tuple[Landmark, ...], info: ValidationInfo) -> tuple[Landmark, ...]:
        points = info.data.get("points", len(value))
        if len(value) > points:
            raise ValueError(f"{len(value)} landmarks are more than `points`, which is {points}")
        if value and info.data.get("objective") == "linf":
            raise ValueError('"linf" takes no landmarks; leave them out, or `objective`')
        if any(len(set(side)) < len(value) for side in zip(*value, strict=True)):
            raise ValueError("a vertex is in two pairs; leave one of them out")
        return value

    @property
    def metrics(self) -> tuple[Choice, ...]:
        """The metrics by level, coarsest first; the last holds for all further levels."""
        return metric_choices(self.metric)

    @property
    def descriptors(self) -> tuple[Choice, ...]:
        """The descriptors by level, coarsest first; the last holds for all further levels."""
        return descriptor_choices(self.descriptor)

    @property
    def needs_spectrum(self) -> bool:
        """Whether any level, or what extends the match, looks at the spectrum of the shapes."""
        described = any(choice.about.spectral for choice in self.descriptors)
        spectral = any(choice.about.spectral for choice in self.metrics)
        return self.extended or spectral or (described and self.first_order_weight > 0)

    @property
    def extended(self) -> bool:
        """Whether the match is extended by a dense map: for itself, or to choose or refine."""
        return self.orientation or self.dense or self.refine is not None

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed of each shape, and kept: no less than any part needs."""
        return max(self.eigenpairs, DENSE_EIGENPAIRS) if self.extended else self.eigenpairs
