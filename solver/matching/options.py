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
        "Points of the coarsest level, which is solved to proven optimality. Default: 8; with a"
        " prototype 10.",
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
        "Target samples for each source sample on the finer levels, with a prototype on all."
        " Samples of two shapes do not correspond exactly, so the target needs more of them.",
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
        "Distance to be preserved. The first metric also samples the points, farthest first. With"
        " the default, the points of the coarsest level are matched a second time, by the Varadhan"
        " approximation of geodesic distance, before geodesic distances are used.",
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
        "Cost of leaving a source point unmatched. Its unit is the weighted energy, in which a"
        " match without distortion costs 0. If left out, every point is matched, except with parts"
        " (`partial`).",
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
        ' samples from above. "linf" uses one level of at most 32 points and matches all of them.'
        " Among its optima it returns those of least energy (5); a warning says if the search for"
        " them was not exhaustive. Twelve points are proven in a second.",
        one_of=(L2, LINF),
        topic="Solver",
    )
    third_order: float = parameter(
        0.0,
        "Weight of the third-order term: signed volumes of triples of points, which distinguish an"
        " answer from its mirror image without a registration. It counts where the coarsest points"
        " are matched; finer levels keep the order of the answers. Volumes are divided by"
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
        'Refinement of the matched points. "gmds", generalized multidimensional scaling, places'
        " them on the target's surface between its vertices: `refinement` of the result. No"
        " refinement if left out.",
        one_of=(GMDS,),
        source="section 7.1",
    )
    orientation: bool = parameter(
        True,
        "Return an orientation-preserving answer: left is matched with left and front with front,"
        " if the surfaces distinguish them. To this end the surfaces are registered, and the result"
        " has a `confidence`; alternatives may have less energy. If false, nothing is registered,"
        " which is faster, but distances alone do not exclude the mirror image. `dense` and"
        " `refine` include it. Surfaces must be wound consistently; closed ones are after repair."
        " With a prototype the surfaces of its examples are registered. It has no effect with a"
        ' prototype without surfaces, or with objective "linf".',
    )
    partial: str = parameter(
        DETECTED,
        "Shape that is a part of the other, if one is. A part has holes or is cut off, and may have"
        ' another scale. "source" and "target" name it; "both": the two overlap, and each lacks'
        ' points of the other; "none": both are wholes. "detected": parts are detected by their'
        " boundary. If one boundary is longer than half of √area, and by a registration as wholes"
        " its surface lacks at least 7.5 % of the other's area, it is matched as a part. If both"
        " boundaries are longer than 0.3 √area, the surfaces are matched as wholes and as"
        " overlapping; the overlap is the answer if either lacks as much, or if the two matches"
        ' disagree. Only with "detected", components that the other shape does not have, such as a'
        " floor, are left out. Points without a partner stay unmatched, vertices without a partner"
        " are left out of `dense`, and `overlap` of the result has the share of each area that has"
        " a partner. Parts are matched at one level, by geodesic distance, with an"
        " `occlusion_cost` of 0.25 unless given. Their scale is found; with `normalise` false it is"
        " that of the files. Not with `refine`.",
        one_of=(DETECTED, SOURCE, TARGET, BOTH, WHOLE),
        topic="Shapes",
    )
    dense: bool = parameter(
        False, "Extend the match to all vertices. The extension is `dense` of the result."
    )
    landmarks: tuple[tuple[int, int], ...] = parameter(
        (),
        "Pairs of vertices that are known to correspond: one of the source's file, one of the"
        " target's, counted from 0. They are sampled first, are matched with one another, and count"
        " among `points`. They decide between symmetric solutions: a pair on a hand distinguishes"
        " left from right. They choose the answer, but do not deform it: the `dense` map may miss"
        ' them, and `refine` "gmds" may move them. A vertex that repair or `simplify` merged into'
        " another is replaced by that one. With `occlusion_cost`, landmarks may stay unmatched."
        ' Not with objective "linf".',
        longest=MAX_LANDMARKS,
    )
    proof: str = parameter(
        SAMPLES,
        'Correspondences that the proof covers. "candidates": those among the candidates of the'
        " finest level: after a registration, the image of each point and the samples within 0.05"
        ' √area of it, two or three on average; otherwise up to twelve for each point. "samples":'
        " also all target samples of the finest level, some 160 for 32 points; `proof` of the"
        " result has the least energy over these. It is the answer if"
        " `orientation` is false; otherwise the orientation-preserving answer stays, which may have"
        ' more energy. With objective "linf", "samples" adds the Gromov-Hausdorff distance of the'
        " samples, `gromov_hausdorff_distance` of the result. No effect with a prototype, and above"
        " some 110 points.",
        one_of=(CANDIDATES, SAMPLES),
        topic="Solver",
    )
    proof_work: float = parameter(
        1.0,
        "Limit of the work of the proof over all samples, in seconds of a typical core. At the"
        ' limit, the best bound so far is returned. With objective "linf" it also limits the search'
        " for the answer. Operations are counted, not time, so that the result is the same on every"
        " machine.",
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
        """True if it is examined whether one shape is a part of the other."""
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
        """True if the surfaces are registered."""
        oriented = self.orientation and self.objective != LINF
        return oriented or self.dense or self.refine == GMDS or self.partial in PARTS

    @property
    def needs_spectrum(self) -> bool:
        """True if some structure that is used is made of Laplace-Beltrami eigenpairs."""
        described = self.first_order_weight > 0.0 and any(f.spectral for f in self.descriptors)
        compared = described or self.third_order > 0.0
        return self.registered or compared or any(d.spectral for d in self.metrics)

    @property
    def least_eigenpairs(self) -> int:
        """Eigenpairs that registration and the descriptors need of each shape, at least."""
        described = self.descriptors if self.first_order_weight > 0.0 else ()
        counts = [1 + f.count for f in described if isinstance(f, Eigenfunctions)]
        return max(EIGENPAIRS if self.registered else 0, *counts, 0)
