"""What is matched with what, and how well: the parts of results of matches."""

from functools import cached_property

import numpy as np
import numpy.typing as npt
from pydantic import FiniteFloat

from isomatch._models.answer import Answer


class Correspondence(Answer):
    """One matched pair of vertices.

    Attributes
    ----------
    source, target
        0-based vertex indices in the uploaded files; of a prototype, numbers of its points.
    cost
        What the pair contributes to the energy.
    """

    source: int
    target: int
    cost: FiniteFloat


class Distortion(Answer):
    """Distortion of a correspondence, section 2 of the paper; lengths on shapes of unit area.

    Attributes
    ----------
    first_order
        Sum of squared differences of descriptors over the pairs; None without a descriptor.
    second_order
        Sum of squared differences of distances over all pairs of pairs.
    linf
        Largest difference of distances.
    """

    first_order: FiniteFloat | None
    second_order: FiniteFloat
    linf: FiniteFloat


class Correspondences(Answer):
    """Matched pairs with their energy and distortion, and the same as arrays."""

    energy: FiniteFloat
    correspondences: tuple[Correspondence, ...]
    distortion: Distortion

    @cached_property
    def pairs(self) -> npt.NDArray[np.int64]:
        """Matched vertex indices, source and target, shape (n, 2), int64."""
        rows = [(pair.source, pair.target) for pair in self.correspondences]
        return np.array(rows, dtype=np.int64).reshape(-1, 2)

    @cached_property
    def costs(self) -> npt.NDArray[np.float64]:
        """What each pair contributes to the energy, shape (n,), float64."""
        return np.array([pair.cost for pair in self.correspondences], dtype=np.float64)


class Alternative(Correspondences):
    """Another good correspondence, often the mirror image of the best.

    Attributes
    ----------
    energy
        Energy of the labelling problem, (5) of the paper.
    correspondences
        The matched pairs.
    distortion
        Their distortion.
    """


class Level(Answer):
    """One level of the coarse-to-fine matching, section 4.1 of the paper.

    Attributes
    ----------
    points, target_points
        Samples on the source and on the target.
    candidates
        Pairs that were considered.
    metric, descriptor
        Names of the structures that were compared.
    energy, lower_bound, gap, certified, iterations, method, seconds
        The answer of the solver, what it proved, and what it took.
    rank
        Place of this answer among all hypotheses by their energy at this level, 1 for the first.
    """

    points: int
    target_points: int
    candidates: int
    metric: str
    descriptor: str
    energy: FiniteFloat
    lower_bound: FiniteFloat
    gap: FiniteFloat
    certified: bool
    iterations: int
    method: str
    seconds: FiniteFloat
    rank: int


class DenseCorrespondence(Answer):
    """A map of all vertices of the source's surface.

    Attributes
    ----------
    hypothesis
        What was extended: 0 for the match's own pairs, j for ``alternatives[j - 1]``, if the map
        that this leads to preserves more.
    source
        Vertex indices in the source's file, ascending: all that the matched surface has.
    target
        The vertex of the target's file that each corresponds to; several may go to one.
    """

    hypothesis: int
    source: tuple[int, ...]
    target: tuple[int, ...]

    @cached_property
    def source_vertices(self) -> npt.NDArray[np.int64]:
        """The same as an array, shape (K,), int64."""
        return np.array(self.source, dtype=np.int64)

    @cached_property
    def target_vertices(self) -> npt.NDArray[np.int64]:
        """The same as an array, shape (K,), int64."""
        return np.array(self.target, dtype=np.int64)
