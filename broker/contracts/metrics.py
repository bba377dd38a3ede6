"""The metrics that can be chosen, sections 3.2 to 3.4 of the paper."""

from typing import Annotated, Final, Literal, TypeAlias, get_args

from pydantic import ConfigDict, Field, Tag
from pydantic.json_schema import SkipJsonSchema
from typing_extensions import TypeAliasType

from broker.contracts.structures import (
    GREATEST,
    LEVELS,
    NAME,
    ONE,
    SEVERAL,
    UNKNOWN,
    About,
    Choice,
    Suited,
    by_name,
    one_or_several,
)

MetricName: TypeAlias = Literal["geodesic", "diffusion", "commute_time", "biharmonic"]


class GeodesicMetric(Choice):
    """Length of the shortest path on the surface."""

    about = About("min ℓ(γ) over paths γ from x to y", "3.2", "length", ("yes", "no", "no"))

    name: Literal["geodesic"]


class DiffusionMetric(Choice):
    """How differently heat spreads from two points in time t: an average over all paths."""

    about = About(
        "d² = Σ exp(-2 λ_i t) (φ_i(x) - φ_i(y))²",
        "3.3, (3)",
        "1/length",
        ("yes", "approx", "no"),
        spectral=True,
    )

    name: Literal["diffusion"]
    time: Annotated[float | None, Suited(0.01, "area")] = Field(
        default=None,
        ge=1.0 / GREATEST,
        le=GREATEST,
        description="Time t, in the square of the shapes' unit of length: heat spreads as far as"
        " 2√t. Null for 0.01 of their area.",
    )


class CommuteTimeMetric(Choice):
    """Root of the time a random walk takes from one point to another and back."""

    about = About(
        "δ² = Σ (φ_i(x) - φ_i(y))² / λ_i",
        "3.4, (4)",
        "1",
        ("yes", "approx", "yes"),
        spectral=True,
    )

    name: Literal["commute_time"]


class BiharmonicMetric(Choice):
    """Between geodesic and diffusion: local where near, aware of the whole shape where far."""

    about = About(
        "d² = Σ (φ_i(x) - φ_i(y))² / λ_i²",
        "Lipman, Rustamov, Funkhouser: Biharmonic distance, ACM TOG 29(3), 2010",
        "length",
        ("yes", "no", "no"),
        spectral=True,
        remarks="Not in Table 1: measured.",
    )

    name: Literal["biharmonic"]


class UnknownMetric(Choice):
    """What an object without the name of a metric is refused by."""

    model_config = ConfigDict(extra="ignore")

    name: MetricName


METRICS: Final[dict[str, type[Choice]]] = {
    "geodesic": GeodesicMetric,
    "diffusion": DiffusionMetric,
    "commute_time": CommuteTimeMetric,
    "biharmonic": BiharmonicMetric,
}

Metric = TypeAliasType(
    "Metric",
    Annotated[
        Annotated[MetricName, Tag(NAME)]
        | Annotated[GeodesicMetric, Tag("choice[geodesic]")]
        | Annotated[DiffusionMetric, Tag("choice[diffusion]")]
        | Annotated[CommuteTimeMetric, Tag("choice[commute_time]")]
        | Annotated[BiharmonicMetric, Tag("choice[biharmonic]")]
        | SkipJsonSchema[Annotated[UnknownMetric, Tag(UNKNOWN)]],
        by_name(get_args(MetricName)),
    ],
)
"""A metric: its name, or that and its parameters."""

MetricByLevel: TypeAlias = Annotated[
    Annotated[Metric, Tag(ONE)] | Annotated[tuple[Metric, ...], LEVELS, Tag(SEVERAL)],
    one_or_several(),
]
"""A metric for all levels, or one for each."""


def metric_choice(given: Choice | str) -> Choice:
    """Return a metric with its parameters, for a name those by default."""
    return METRICS[given](name=given) if isinstance(given, str) else given


def metric_choices(given: MetricByLevel) -> tuple[Choice, ...]:
    """Return metrics with their parameters, of one for all levels or of one for each."""
    return tuple(map(metric_choice, given if isinstance(given, tuple) else (given,)))
