"""What a caller may choose when two shapes are matched."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self, TypeVar

import numpy as np

from solver.errors import OptionError
from solver.labelling import L2, LINF
from solver.shape.choices import (
    DescriptorChoice,
    MetricChoice,
    Structure,
    descriptor_choice,
    metric_choice,
)

ChoiceT = TypeVar("ChoiceT", bound=Structure)

"""What a correspondence may minimise."""

GMDS = "gmds"
"""How it may be refined."""

MIN_POINTS = 3
MAX_POINTS = 256
MAX_COARSE_POINTS = 10
MAX_LANDMARKS = 32


@dataclass(frozen=True)
class MatchOptions:
    """Choices of a match; the paper's symbols in parentheses.

    Parameters
    ----------
    points
        Source points matched at the finest level.
    coarse_points
        Source points of the coarsest level, matched exactly (N₁ of 4.1).
    level_factor
        How many times more points each level has than the one before (q of 4.1).
    oversampling
        Target samples per source sample above the coarsest level. The samples of two shapes are
        not images of one another, so the target needs more of them than the source.
    rho
        Size of the neighbourhoods in which partners are looked for, in covering radii (ρ of 4.1).
    metric
        Metric d of each level, from the coarsest on; the last serves all finer levels. Each is
        a choice, or a name, which is the choice with default parameters. Points are sampled
        farthest first in the first one. Between commute times and geodesic distances the coarsest
        level's points are matched a second time, by heat: see :mod:`.varadhan_level`.
    descriptor
        Descriptor f of each level, likewise; ``"none"`` leaves the first-order term out.
    beta
        Weight of the second-order term (β). Distances are divided by their root mean square
        and pairs weighed by 2/(N − 1), so that 1 means the same for any metric and any N.
    first_order_weight
        Weight of the first-order term. Descriptors are divided by their root mean square
        deviation, so that 1 means the same for any descriptor.
    occlusion_cost
        What an unmatched source point costs (γ), in the units of the weighted energy, in which a
        match without any distortion costs 0; ``None`` for enough that every one is matched.
    alternatives
        How many of the best coarse solutions are refined and ranked.
    objective
        What a correspondence minimises: ``"l2"``, the energy (5), or ``"linf"``, the greatest
        distortion of a distance (section 2), whose half is the Gromov-Hausdorff distance of the
        sampled points if each has one partner. The latter is solved exactly, on one level of at
        most 10 points; among its optima, those of least energy (5) are returned.
    refine
        ``"gmds"`` to find, after the match, the points of the target's surface that correspond to
        the matched points, between its vertices: see :mod:`solver.gmds`. ``None`` not to.
    orientation
        Whether of the hypotheses that one is returned whose extension to all vertices preserves
        most and keeps orientation, so that left is matched with left, rather than the likeliest by
        distances, of which the mirror image is as good; its points then lie where that extension
        has them. `dense` and `refine` include that.
        With objective ``"linf"`` the answer stays that of least distortion.
    dense
        Whether to extend the match to all vertices: see :mod:`solver.functional_maps.extension`.
    landmarks
        Pairs of vertices known to correspond, in the numbers of the user's own files. They are
        sampled first, before the farthest points, at every level, and matched with one another.
        At most 32, and no more than points; not for objective ``"linf"``.
    time_limit
        Seconds after which the best answer so far is returned; ``None`` for no limit.

    Raises
    ------
    OptionError
        A value is out of range.
    """

    points: int = 32
    coarse_points: int = 8
    level_factor: int = 2
    oversampling: int = 4
    rho: float = 1.5
    metric: tuple[MetricChoice | str, ...] = ("commute_time", "geodesic")
    descriptor: tuple[DescriptorChoice | str, ...] = ("si_hks",)
    beta: float = 1.0
    first_order_weight: float = 0.05
    occlusion_cost: float | None = None
    alternatives: int = 8
    objective: str = L2
    refine: str | None = None
    orientation: bool = False
    dense: bool = False
    landmarks: tuple[tuple[int, int], ...] = ()
    time_limit: float | None = None

    def __post_init__(self) -> None:
        self._within("points", MIN_POINTS, MAX_POINTS)
        self._within("coarse_points", MIN_POINTS, MAX_COARSE_POINTS)
        self._within("level_factor", 2, 4)
        self._within("oversampling", 1, 8)
        self._within("rho", 1.0, 4.0)
        self._within("beta", 0.0, 1e6)
        self._within("first_order_weight", 0.0, 1e6)
        self._within("alternatives", 1, 32)
        self._choose("metric", metric_choice)
        self._choose("descriptor", descriptor_choice)
        self._suits_the_objective()
        self._check_landmarks()
        if self.refine not in (None, GMDS):
            raise OptionError("refine", f"{self.refine!r} is not {GMDS}; or leave it out")
        for field in ("occlusion_cost", "time_limit"):
            value = getattr(self, field)
            if value is not None and not 0.0 < value < np.inf:
                raise OptionError(field, "it must be positive and finite, or left out")

    def _suits_the_objective(self) -> None:
        if self.objective not in (L2, LINF):
            raise OptionError("objective", f"{self.objective!r} is none of {L2}, {LINF}")
        if self.objective == LINF and self.points > MAX_COARSE_POINTS:
            raise OptionError("points", f"objective {LINF} takes at most {MAX_COARSE_POINTS}")
        if self.objective == LINF and self.occlusion_cost is not None:
            raise OptionError("occlusion_cost", f"objective {LINF} matches every point")

    def _check_landmarks(self) -> None:
        count = len(self.landmarks)
        if count > min(MAX_LANDMARKS, self.points):
            most = f"{MAX_LANDMARKS} are possible, and no more than points"
            raise OptionError("landmarks", f"{count} are too many: {most}")
        if count and self.objective == LINF:
            raise OptionError("landmarks", f"objective {LINF} takes none")
        for side in range(2):
            seen: set[int] = set()
            for place, pair in enumerate(self.landmarks):
                if pair[side] in seen:
                    raise OptionError(f"landmarks.{place}.{side}", "it is in an earlier pair")
                seen.add(pair[side])

    def _within(self, field: str, least: float, most: float) -> None:
        if not least <= getattr(self, field) <= most:
            raise OptionError(field, f"it must be from {least:g} to {most:g}")

    def _choose(self, field: str, choice: Callable[[ChoiceT | str, str], ChoiceT]) -> None:
        """Replace names by the choices they mean."""
        given = getattr(self, field)
        if not given:
            raise OptionError(field, "at least one is needed")
        chosen = tuple(choice(one, f"{field}.{place}") for place, one in enumerate(given))
        object.__setattr__(self, field, chosen)

    @property
    def metrics(self) -> tuple[MetricChoice, ...]:
        """The metrics of the levels, the coarsest first; the last serves all finer ones."""
        return tuple(map(metric_choice, self.metric))

    @property
    def descriptors(self) -> tuple[DescriptorChoice, ...]:
        """The descriptors of the levels, likewise."""
        return tuple(map(descriptor_choice, self.descriptor))

    def metric_at(self, level: int) -> MetricChoice:
        """Metric of a level, 0 for the coarsest."""
        return self.metrics[self.place("metric", level)]

    def descriptor_at(self, level: int) -> DescriptorChoice:
        """Descriptor of a level, 0 for the coarsest."""
        return self.descriptors[self.place("descriptor", level)]

    def place(self, field: str, level: int) -> int:
        """Place of a level's structure among those given in "metric" or "descriptor"."""
        return min(level, len(getattr(self, field)) - 1)

    def settled(self, length: float) -> Self:
        """Return the options with a value for every parameter of the structures.

        Parameters
        ----------
        length
            √area of the shapes, in their unit of length; 1 if they are normalised.
        """
        return replace(
            self,
            metric=tuple(choice.settled(length) for choice in self.metrics),
            descriptor=tuple(choice.settled(length) for choice in self.descriptors),
        )

    @property
    def extended(self) -> bool:
        """Whether hypotheses are extended to all vertices."""
        return self.orientation or self.dense or self.refine == GMDS

    @property
    def needs_spectrum(self) -> bool:
        """Whether some structure that is used is made of Laplace-Beltrami eigenpairs."""
        described = self.first_order_weight > 0.0 and any(f.spectral for f in self.descriptors)
        return self.extended or described or any(d.spectral for d in self.metrics)
