"""Options of a match, each declared with its range, default, meaning and source."""

from dataclasses import dataclass, replace
from typing import Self

from solver.errors import OptionError
from solver.labelling import L2, LINF
from solver.parameters import ParameterSet, parameter
from solver.registration import EIGENPAIRS
from solver.shape.choices import (
    DESCRIPTORS,
    METRICS,
    DescriptorChoice,
    Eigenfunctions,
    MetricChoice,
    all_chosen,
    descriptor_choice,
    metric_choice,
)

GMDS = "gmds"
"""Generalized multidimensional scaling, the one method of refinement."""

CANDIDATES = "candidates"
"""Scope of a certificate: the candidates of its level."""
SAMPLES = "samples"
"""Scope of a certificate: all target samples of its level."""

DETECTED = "detected"
SOURCE = "source"
TARGET = "target"
BOTH = "both"
WHOLE = "none"
"""Which shape is a part of the other; both are, where each lacks points of the other."""

PARTS = SOURCE, TARGET, BOTH
"""Values of `partial` with which the shapes are matched as a part and a whole, or as two parts."""

MIN_POINTS = 3
MAX_POINTS = 256
COARSE_POINTS = 8
"""Points of the coarsest level of two shapes, unless given."""
MAX_COARSE_POINTS = 10
MAX_MINIMAX_POINTS = 32
MAX_LANDMARKS = 32


@dataclass(frozen=True)
class MatchOptions(ParameterSet):
    """Options of a match.

    ``metric`` and ``descriptor`` hold one structure for each level from the coarsest on, of which
    the last serves all finer levels; a name stands for the structure with default parameters.

    Raises
    ------
    OptionError
        A value is out of range, or two options exclude each other.
    """

    points: int = parameter(
        32, "Points of the source matched at the finest level.", least=MIN_POINTS, most=MAX_POINTS
    )
    coarse_points: int | None = parameter(
        None,
        "Points of the coarsest level, which is solved to proven optimality; if left out, 8, and 10"
        " with a prototype.",
        least=MIN_POINTS,
        most=MAX_COARSE_POINTS,
        source="N_1 of section 4.1",
        topic="Solver",
    )
    level_factor: int = parameter(
        2,
        "Factor by which the number of points grows from one level to the next.",
        least=2,
        most=4,
        source="q of section 4.1",
        topic="Solver",
    )
    oversampling: int = parameter(
        4,
        "Target samples for each source sample on the finer levels. Samples of two shapes do not"
        " correspond exactly, so the target needs more of them.",
        least=1,
        most=8,
        topic="Solver",
    )
    rho: float = parameter(
        1.5,
        "Radius of the neighbourhood in which a match may move from one level to the next, in"
        " covering radii of the level.",
        above=1.0,
        most=4.0,
        source="section 4.1",
        topic="Solver",
    )
    metric: tuple[MetricChoice | str, ...] = parameter(
        ("commute_time", "geodesic"),
        "Distance to be preserved. Points are sampled farthest first in the first metric. Between"
        " commute times and geodesic distances, the points of the coarsest level are matched a"
        " second time, by the Varadhan approximation of geodesic distance.",
        topic="Structures",
    )
    descriptor: tuple[DescriptorChoice | str, ...] = parameter(
        ("si_hks",),
        'Local descriptor to be preserved. "none" leaves the first-order term out.',
        topic="Structures",
    )
    beta: float = parameter(
        1.0,
        "Weight of the second-order (metric) term. Distances are divided by their root mean square"
        " and pairs weighted by 2/(N - 1), so that 1 means the same for every metric and every N.",
        least=0.0,
        most=1e6,
        source="beta of (5)",
        topic="Solver",
    )
    first_order_weight: float = parameter(
        0.05,
        "Weight of the first-order (descriptor) term. Descriptors are divided by their root mean"
        " square deviation, so that 1 means the same for every descriptor.",
        least=0.0,
        most=1e6,
        topic="Solver",
    )
    occlusion_cost: float | None = parameter(
        None,
        "Cost of leaving a source point unmatched. In units of the weighted energy, in which a"
        " match without distortion costs 0; if left out, large enough that every point is matched.",
        above=0.0,
        most=1e9,
        source="gamma of (5)",
        topic="Shapes",
    )
    alternatives: int = parameter(
        8,
        "Number of best solutions of the coarsest level that are refined and ranked.",
        least=1,
        most=32,
        topic="Solver",
    )
    objective: str = parameter(
        L2,
        'Quantity that is minimised. "l2" is the energy (5); "linf" the greatest distortion of a'
        " distance (section 2), half of which bounds the Gromov-Hausdorff distance of the matched"
        ' samples from above. "linf" takes one level of at most 32 points, matches all of them, and'
        " of its optima returns those of least energy (5). Twelve points are proven in a second.",
        one_of=(L2, LINF),
        topic="Solver",
    )
    third_order: float = parameter(
        0.0,
        "Weight of the third-order term: signed volumes of triples of points, which tell an answer"
        " from its mirror image without a registration. It counts where the coarsest points are"
        " matched; finer levels keep the order of the answers found there. Volumes are divided by"
        " their root mean square and weighted by points over triples, so that 1 means the same for"
        " every number of points; 0.03 suits most shapes. Surfaces must be wound consistently. Not"
        ' with objective "linf", and not with a prototype.',
        least=0.0,
        most=1e6,
        source="section 7.1",
        topic="Solver",
    )
    refine: str | None = parameter(
        None,
        'Refinement of the matched points. "gmds" finds where they lie on the target\'s surface'
        " between its vertices, by generalized multidimensional scaling: `refinement` of the"
        " result. No refinement if left out.",
        one_of=(GMDS,),
        source="section 7.1",
    )
    orientation: bool = parameter(
        True,
        "Return the direct answer: left is matched with left and front with front, wherever the"
        " surfaces tell them apart. They are registered for it, and `confidence` of the result says"
        " how sure the answer is; alternatives may have less energy. If false, nothing is"
        " registered, which is faster: distances alone decide, and the mirror image is as good."
        " `dense` and `refine` include it. Surfaces must be wound consistently, as closed ones are"
        " after repair. With a prototype the surfaces of its examples decide; without them, and"
        ' with objective "linf", whose answer stays that of least distortion, it has no effect.',
    )
    partial: str = parameter(
        DETECTED,
        "Whether one shape is a part of the other, with holes or cut off, of unknown scale:"
        ' "source", "target", "both", or "none". With "both" the two overlap, and each lacks points'
        ' of the other. With "detected", both are matched as wholes, and again with the one with'
        " more boundary as a part, if that boundary is longer than half of √area and it lacks more"
        " than a thirteenth of the other's area by that match; where both boundaries are longer"
        " than 0.3 √area, again as overlapping, which is the answer if either lacks as much or the"
        " two disagree."
        " Then, too, components that the other shape has nothing of, such as a floor, are left out."
        " Points without a partner stay unmatched, vertices without one are left out of `dense`;"
        " `overlap` of the result tells which shares of both have one. Points are matched at"
        " one level, by geodesic distance, and `occlusion_cost` is 0.25 unless given. With"
        " `normalise` false the scale is that of the files, else it is found. Not with `refine`.",
        one_of=(DETECTED, SOURCE, TARGET, BOTH, WHOLE),
        topic="Shapes",
    )
    dense: bool = parameter(
        False, "Extend the match to all vertices. The extension is `dense` of the result."
    )
    landmarks: tuple[tuple[int, int], ...] = parameter(
        (),
        "Pairs of vertices that are known to correspond. One is of the source's file, the other of"
        " the target's, counted from 0. They are sampled first and matched with one another, count"
        " among `points`, and decide between symmetric solutions: one on a hand distinguishes left"
        " from right. They choose the answer, and do not bend it: the `dense` map may lead beside"
        ' them, and `refine` "gmds" may move them. A vertex that repair or `simplify` has merged'
        " into another is replaced by that one. With `occlusion_cost`, they may stay unmatched too."
        ' Not with objective "linf".',
        longest=MAX_LANDMARKS,
    )
    proof: str = parameter(
        SAMPLES,
        'Correspondences that the answer is compared with. "candidates": those of the finest level,'
        ' about twelve target samples for each point. "samples": in addition, the least energy over'
        " all target samples of the finest level, with a proof: `proof` of the result. It replaces"
        " the answer if `orientation` is false; else the direct answer stays, which may have more"
        ' energy. With objective "linf": the Gromov-Hausdorff distance of the samples,'
        " `gromov_hausdorff_distance` of the result. No effect with a prototype, and above some 110"
        " points.",
        one_of=(CANDIDATES, SAMPLES),
        topic="Solver",
    )
    proof_work: float = parameter(
        1.0,
        "Limit of the work of the proof over all samples, in seconds of a typical core. The bound"
        ' known by then is returned. With objective "linf" it limits the answer, too. Operations'
        " are counted, not time, so that the result is the same on every machine.",
        above=0.0,
        most=86400.0,
        topic="Solver",
    )
    time_limit: float | None = parameter(
        None,
        "Seconds after which the best answer so far is returned with its gap. No limit if left"
        " out.",
        above=0.0,
        most=86400.0,
        unit="seconds",
        topic="Solver",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "metric", all_chosen(self.metric, METRICS, "metric"))
        object.__setattr__(
            self, "descriptor", all_chosen(self.descriptor, DESCRIPTORS, "descriptor")
        )
        if self.objective == LINF:
            self._check_linf()
        self._check_landmarks()

    @property
    def may_be_partial(self) -> bool:
        """Whether it is looked whether one shape is a part of the other."""
        plain = self.refine is None and self.objective != LINF
        return self.partial == DETECTED and plain and self.registered

    def _check_linf(self) -> None:
        if self.points > MAX_MINIMAX_POINTS:
            raise OptionError("points", f"objective {LINF} takes at most {MAX_MINIMAX_POINTS}")
        if self.occlusion_cost is not None:
            raise OptionError("occlusion_cost", f"objective {LINF} matches every point")
        if self.landmarks:
            raise OptionError("landmarks", f"objective {LINF} takes none")
        if self.third_order > 0.0:
            raise OptionError("third_order", f"objective {LINF} has no third-order term")
        if self.partial in PARTS:
            raise OptionError("partial", f"objective {LINF} matches every point")

    def _check_landmarks(self) -> None:
        count = len(self.landmarks)
        if count > min(MAX_LANDMARKS, self.points):
            most = f"{MAX_LANDMARKS} are possible, and no more than points"
            raise OptionError("landmarks", f"{count} are too many: {most}")
        for shape in range(2):
            seen: set[int] = set()
            for place, pair in enumerate(self.landmarks):
                if pair[shape] in seen:
                    raise OptionError(f"landmarks.{place}.{shape}", "it is in an earlier pair")
                seen.add(pair[shape])

    @property
    def metrics(self) -> tuple[MetricChoice, ...]:
        """The metrics of the levels, the coarsest first; the last holds for all finer ones."""
        return tuple(map(metric_choice, self.metric))

    @property
    def descriptors(self) -> tuple[DescriptorChoice, ...]:
        """The descriptors of the levels, the coarsest first; the last holds for all finer ones."""
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
    def registered(self) -> bool:
        """Whether the surfaces are registered."""
        oriented = self.orientation and self.objective != LINF
        return oriented or self.dense or self.refine == GMDS or self.partial in PARTS

    @property
    def needs_spectrum(self) -> bool:
        """Whether some structure that is used is made of Laplace-Beltrami eigenpairs."""
        described = self.first_order_weight > 0.0 and any(f.spectral for f in self.descriptors)
        compared = described or self.third_order > 0.0
        return self.registered or compared or any(d.spectral for d in self.metrics)

    @property
    def least_eigenpairs(self) -> int:
        """Eigenpairs that registration and the descriptors need of each shape, at least."""
        described = self.descriptors if self.first_order_weight > 0.0 else ()
        counts = [1 + f.count for f in described if isinstance(f, Eigenfunctions)]
        return max(EIGENPAIRS if self.registered else 0, *counts, 0)
