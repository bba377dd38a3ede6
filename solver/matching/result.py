"""The answer to "which point of X corresponds to which point of Y, and how well?"."""

from collections.abc import Mapping
from dataclasses import dataclass

from solver.arrays import FloatArray, IntArray
from solver.functional_maps import DenseCorrespondence
from solver.gmds import GmdsRefinement
from solver.labelling import CERTIFIED_GAP, Distortion, Method, relative_gap


@dataclass(frozen=True, eq=False)
class Correspondence:
    """Pairs of points, with what they cost.

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
    """What was solved at one level, and what is known of its optimum.

    Parameters
    ----------
    points, target_points
        Numbers N and M of samples.
    candidates
        Number |V| of candidate pairs.
    metric, descriptor
        Structures of the level.
    energy
        At the coarsest of several levels, of its best solution; else of the answer's hypothesis.
    lower_bound
        No correspondence among the level's candidates has less energy.
    iterations
        Iterations of the dual decomposition, or nodes of the search.
    method
        How the bound was found.
    seconds
        Time spent on the level.
    rank
        Place, from 1, of the answer's hypothesis among all hypotheses by their energy at this
        level. More than 1 means that a finer level overruled it, or the rest of the surface.
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

    @property
    def gap(self) -> float:
        """Relative distance of the bound from the energy, in [0, 1]."""
        return relative_gap(self.energy, self.lower_bound)

    @property
    def certified(self) -> bool:
        """Whether the energy is proven optimal among the level's candidates."""
        return self.gap <= CERTIFIED_GAP


@dataclass(frozen=True, eq=False)
class Match:
    """A minimum-distortion correspondence with its certificate.

    Parameters
    ----------
    best
        The answer.
    alternatives
        Other hypotheses, as refined to the finest level; most often intrinsic symmetries. By what
        the rest of the surface says of them; some may have less energy than `best`. With metrics
        other than commute times and then geodesic distances, and of a prototype, they come by
        energy, and none is better than `best` unless orientation chose it.
    levels
        From the coarsest; the last one's bound is the certificate of `best`.
    warnings
        What the user should know of the shapes and of the answer.
    timings
        Seconds by stage.
    refinement
        Where the points of `best` lie between the target's vertices, if that was asked for. Its
        hypothesis is 0 for `best`, or one more than a place among `alternatives`; its vertices and
        faces are those of the shapes' meshes, not of the user's files.
    dense
        Where all vertices go, if that was asked for; of the same hypothesis.
    misfit
        Of a prototype, how much the target misfits the class: the energy per point at the coarsest
        level over what is usual of examples left out, 1 for a usual one. ``None`` of two shapes, of
        prototypes that do not know what is usual, and of terms weighed otherwise.
    """

    best: Correspondence
    alternatives: tuple[Correspondence, ...]
    levels: tuple[LevelReport, ...]
    warnings: tuple[str, ...]
    timings: Mapping[str, float]
    refinement: GmdsRefinement | None = None
    dense: DenseCorrespondence | None = None
    misfit: float | None = None

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
        """Whether the answer is proven optimal among the finest level's candidates."""
        return self.levels[-1].certified
