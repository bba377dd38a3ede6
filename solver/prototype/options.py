"""Options of a prototype, each declared with its range, default, meaning and source."""

from dataclasses import dataclass

from solver.matching import MAX_POINTS, MIN_POINTS
from solver.parameters import ParameterSet, parameter
from solver.shape.choices import (
    DESCRIPTORS,
    METRICS,
    DescriptorChoice,
    MetricChoice,
    all_chosen,
    descriptor_choice,
    metric_choice,
)

MAX_COMPONENTS = 16


@dataclass(frozen=True)
class PrototypeStructures(ParameterSet):
    """Structures that a prototype describes, as those of a match: one for each level.

    Raises
    ------
    OptionError
        There is no such structure.
    """

    metric: tuple[MetricChoice | str, ...] = parameter(
        ("geodesic",),
        "Distance between points, whose distribution is learned.",
        topic="Structures",
    )
    descriptor: tuple[DescriptorChoice | str, ...] = parameter(
        ("si_hks",),
        'Local descriptor of every point. "none" for distances alone. Eigenfunctions cannot be'
        " learned, because their signs differ between shapes.",
        topic="Structures",
    )
    sampling: tuple[MetricChoice | str, ...] = parameter(
        ("commute_time", "geodesic"),
        "Metrics in which points are sampled, farthest first and in turns. Points of the prototype"
        " are sampled on the reference, in the first metric. Where one metric samples the fingers"
        " of a body first, another finds its head.",
        topic="Structures",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "metric", all_chosen(self.metric, METRICS, "metric"))
        object.__setattr__(self, "sampling", all_chosen(self.sampling, METRICS, "sampling"))
        object.__setattr__(
            self, "descriptor", all_chosen(self.descriptor, DESCRIPTORS, "descriptor")
        )

    @property
    def sampling_metrics(self) -> tuple[MetricChoice, ...]:
        """Metrics in which points are sampled."""
        return tuple(map(metric_choice, self.sampling))

    @property
    def metrics(self) -> tuple[MetricChoice, ...]:
        """The metrics of the levels, the coarsest first."""
        return tuple(map(metric_choice, self.metric))

    @property
    def descriptors(self) -> tuple[DescriptorChoice, ...]:
        """The descriptors of the levels, the coarsest first."""
        return tuple(map(descriptor_choice, self.descriptor))


@dataclass(frozen=True)
class PrototypeOptions(PrototypeStructures):
    """Options of learning a prototype.

    Raises
    ------
    OptionError
        A value is out of range.
    """

    points: int = parameter(
        32,
        "Points of the prototype. If correspondences are given, that many of them are taken,"
        " farthest first; the service takes all of them if this is left out.",
        least=MIN_POINTS,
        most=MAX_POINTS,
    )
    components: int = parameter(
        5,
        "Gaussians of each mixture. No more than half the number of examples are used.",
        least=1,
        most=MAX_COMPONENTS,
        source="K of section 6.4",
        topic="Mixtures",
    )
    select_components: bool = parameter(
        False,
        "Choose the number of Gaussians of each mixture, up to `components`, by the Bayesian"
        " information criterion.",
        topic="Mixtures",
    )
    seed: int = parameter(
        0,
        "Seed of the random starts of expectation maximisation. The same seed gives the same"
        " prototype.",
        least=0,
        most=2**31 - 1,
        topic="Mixtures",
    )
