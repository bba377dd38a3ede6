"""Result of a match: correspondences, level reports and the certificate."""

from collections.abc import Mapping
from dataclasses import dataclass

from solver.arrays import FloatArray, IntArray
from solver.gmds import GmdsRefinement
from solver.labelling import CERTIFIED_GAP, Distortion, Method, relative_gap
from solver.registration import Confidence, DenseCorrespondence


@dataclass(frozen=True, eq=False)
class Correspondence:
    """A correspondence with its costs.

    Parameters
    ----------
    source, target
        (K,) the user's own vertex numbers of the paired points.
    costs
        (K,) each pair's share of the energy: its first-order cost and half its second-order
        costs with the other pairs.
    unmatched
        (N − K,) the user's vertex numbers of the source points left unmatched.
    energy
        (5) plus γN: the sum of the costs and γ for every unmatched point; 0 for a correspondence
        without distortion.
    distortion
        Distortions (section 2) in the structures' own units.
    """

    source: IntArray
    target: IntArray
    costs: FloatArray
    unmatched: IntArray
    energy: float
    distortion: Distortion


@dataclass(frozen=True)
class LevelReport:
    """Problem of one level, its energy and its lower bound.

    Parameters
    ----------
    points, target_points
        Numbers N and M of samples.
    candidates
        Number |V| of candidate pairs.
    metric, descriptor
        Structures of the level.
    energy
        Least energy at the coarsest of several levels; at others, that of the answer's hypothesis.
    lower_bound
        No correspondence among the level's candidates has less energy.
    iterations
        Iterations of the dual decomposition, or nodes of the search.
    method
        How the bound was found.
    seconds
        Time spent on the level.
    rank
        Place, from 1, of the answer's hypothesis among it and the alternatives' by their energy at
        this level. More than 1: a finer level, the registration or a third-order term preferred it.
    scope
        Correspondences that the bound holds for: ``"samples"`` if all target samples of the level
        are candidates, else ``"candidates"``.
    """

    points: int
    target_points: int
    candidates: int
    metric: str
    descriptor: str
    energy: float
    lower_bound: float
    iterations: int
    method: Method
    seconds: float
    rank: int
    scope: str

    @property
    def gap(self) -> float:
        """Relative distance of the bound from the energy, in [0, 1]."""
        return relative_gap(self.energy, self.lower_bound)

    @property
    def certified(self) -> bool:
        """Return whether the energy is proven optimal among the level's candidates."""
        return self.gap <= CERTIFIED_GAP


@dataclass(frozen=True, eq=False)
class SampleProof:
    """Least energy over all target samples of the finest level, with its certificate.

    Parameters
    ----------
    target_points
        Number M of target samples.
    candidates
        Number of pairs of samples: N·M without landmarks.
    optimum
        The correspondence of least energy that is known. It may differ from the direct answer, for
        instance by an intrinsic symmetry.
    lower_bound
        No correspondence among these samples has less energy.
    regions
        Regions of the branch and bound.
    seconds
        Time spent.
    """

    target_points: int
    candidates: int
    optimum: Correspondence
    lower_bound: float
    regions: int
    seconds: float

    @property
    def energy(self) -> float:
        """Energy of the optimum."""
        return self.optimum.energy

    @property
    def gap(self) -> float:
        """Relative distance of the bound from the energy, in [0, 1]."""
        return relative_gap(self.energy, self.lower_bound)

    @property
    def certified(self) -> bool:
        """Return whether the optimum is proven."""
        return self.gap <= CERTIFIED_GAP


@dataclass(frozen=True, eq=False)
class GromovHausdorff:
    """Gromov-Hausdorff distance of the samples of two shapes (section 2), with its certificate.

    The sampled shapes are finite metric spaces. Correspondences are relations here: every sample of
    either shape is in one pair or more.

    Parameters
    ----------
    points
        Number N of samples of either shape.
    source, target
        (K,) the user's own vertex numbers of the pairs of the best correspondence, K < 2N.
    costs
        (K,) greatest distortion |d_X − d_Y| of each pair with another.
    value
        Half of the greatest distortion: the distance, or an upper bound.
    lower_bound
        No correspondence of these samples has a smaller value.
    sampling_error
        Sum of the covering radii of both samplings. By the triangle inequality, the distance of the
        two sets of all vertices differs from that of the samples by at most this.
    seconds
        Time spent.
    """

    points: int
    source: IntArray
    target: IntArray
    costs: FloatArray
    value: float
    lower_bound: float
    sampling_error: float
    seconds: float

    @property
    def gap(self) -> float:
        """Relative distance of the bound from the value, in [0, 1]."""
        return relative_gap(self.value, self.lower_bound)

    @property
    def certified(self) -> bool:
        """Return whether the value is proven to be the distance."""
        return self.gap <= CERTIFIED_GAP


@dataclass(frozen=True)
class Overlap:
    """Common region of two shapes, one of which is a part of the other, or which overlap.

    Parameters
    ----------
    part
        ``"source"`` or ``"target"``: which is the part; ``"both"`` if neither has all of the other.
    scale
        Factor from lengths of the source to those of the target, in the units of the files.
    source, target
        Shares of the areas of both that have a partner on the other.
    """

    part: str
    scale: float
    source: float
    target: float


@dataclass(frozen=True, eq=False)
class Match:
    """A minimum-distortion correspondence with its certificate.

    Parameters
    ----------
    best
        The answer.
    alternatives
        Other hypotheses at the finest level, mostly intrinsic symmetries, in the order of their
        energy. None has less than `best`, unless a registration or a third-order term chose that.
    levels
        From the coarsest; the last one's bound is the certificate of `best`.
    warnings
        For the user, about the shapes and the answer.
    timings
        Seconds by stage.
    refinement
        Points of `best` refined between the target's vertices, if asked for. Its hypothesis is 0
        for `best`, or one more than a place among `alternatives`; its vertices and faces are those
        of the shapes' meshes, not of the user's files.
    dense
        Map of all vertices, if asked for; of the same hypothesis.
    misfit
        Of a prototype: energy per point at the coarsest level over its median for left-out
        examples. ``None`` for two shapes, if that median is not known, and for other weights.
    confidence
        Probability that `best` is right, and reasons for doubt. ``None`` where the surfaces were
        not registered: `orientation` off, objective "linf", or a prototype.
    proof
        Least energy over all target samples of the finest level. ``None`` if not asked for, with
        objective "linf", of a prototype, and of too many samples.
    gromov_hausdorff_distance
        Of the samples of both shapes. ``None`` if not asked for, or with another objective.
    overlap
        What the shapes have in common, where one was matched as a part of the other, or both.
    """

    best: Correspondence
    alternatives: tuple[Correspondence, ...]
    levels: tuple[LevelReport, ...]
    warnings: tuple[str, ...]
    timings: Mapping[str, float]
    refinement: GmdsRefinement | None = None
    dense: DenseCorrespondence | None = None
    misfit: float | None = None
    confidence: Confidence | None = None
    proof: SampleProof | None = None
    gromov_hausdorff_distance: GromovHausdorff | None = None
    overlap: Overlap | None = None

    @property
    def lower_bound(self) -> float:
        """No correspondence among the finest level's candidates has less energy."""
        return self.levels[-1].lower_bound

    @property
    def gap(self) -> float:
        """Relative distance of the bound from the energy, in [0, 1]."""
        return self.levels[-1].gap

    @property
    def certified(self) -> bool:
        """Return whether the answer is proven optimal among the finest level's candidates."""
        return self.levels[-1].certified
