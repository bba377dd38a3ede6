"""What a caller may choose when a prototype is learned."""

from dataclasses import dataclass

from solver.errors import OptionError
from solver.matching import MAX_POINTS, MIN_POINTS
from solver.shape.choices import DescriptorChoice, MetricChoice, descriptor_choice, metric_choice

MAX_COMPONENTS = 16


@dataclass(frozen=True)
class PrototypeOptions:
    """Choices of a prototype; the paper's symbols in parentheses.

    Parameters
    ----------
    points
        Points N of the prototype.
    components
        Gaussians K of each mixture; no more than half the number of examples are used.
    select_components
        Whether each mixture has the number of components, up to K, of least Bayesian information
        criterion.
    metric
        Metric d of each level of a match, from the coarsest on; the last serves all finer ones.
        Each is a choice, or a name, which is the choice with default parameters.
    descriptor
        Descriptor f of each level, likewise; ``"none"`` leaves the first-order term out.
    sampling
        Metrics in which targets are sampled farthest first, by turns; points of the prototype are
        sampled on the reference in the first. Where one metric spends its samples on the fingers of
        one body, another still finds its head.
    seed
        Of the random starts of expectation maximisation.

    Raises
    ------
    OptionError
        A value is out of range.
    """

    points: int = 32
    components: int = 5
    select_components: bool = False
    metric: tuple[MetricChoice | str, ...] = ("geodesic",)
    descriptor: tuple[DescriptorChoice | str, ...] = ("si_hks",)
    sampling: tuple[MetricChoice | str, ...] = ("commute_time", "geodesic")
    seed: int = 0

    def __post_init__(self) -> None:
        if not MIN_POINTS <= self.points <= MAX_POINTS:
            raise OptionError("points", f"it must be from {MIN_POINTS} to {MAX_POINTS}")
        if not 1 <= self.components <= MAX_COMPONENTS:
            raise OptionError("components", f"it must be from 1 to {MAX_COMPONENTS}")
        if self.seed < 0:
            raise OptionError("seed", "it must be at least 0")
        for field in ("metric", "descriptor", "sampling"):
            if not getattr(self, field):
                raise OptionError(field, "at least one is needed")
        for field, given in (("metric", self.metric), ("sampling", self.sampling)):
            metrics = tuple(metric_choice(one, f"{field}.{i}") for i, one in enumerate(given))
            object.__setattr__(self, field, metrics)
        descriptors = tuple(
            descriptor_choice(one, f"descriptor.{i}") for i, one in enumerate(self.descriptor)
        )
        object.__setattr__(self, "descriptor", descriptors)

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
        """The descriptors of the levels, likewise."""
        return tuple(map(descriptor_choice, self.descriptor))
