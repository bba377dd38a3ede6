"""Correspondences of vertices, sparse and dense, and their distortion."""

from functools import cached_property
from typing import Annotated, Final

import numpy as np
import numpy.typing as npt
from pydantic import Field, FiniteFloat

from isomatch._models.answer import Answer
from isomatch._models.vertex_map import VertexMap

_OF_THREE: Final = Field(min_length=3, max_length=3)


class Correspondence(Answer):
    """One matched pair of vertices.

    Attributes
    ----------
    source, target
        0-based vertex indices in the uploaded files; for a prototype, point numbers.
    cost
        Contribution of the pair to the energy; with the objective ``"linf"`` its largest
        distortion.
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
        """Matched vertex indices of source and target, (n, 2) int64."""
        rows = [(pair.source, pair.target) for pair in self.correspondences]
        return np.array(rows, dtype=np.int64).reshape(-1, 2)

    @cached_property
    def costs(self) -> npt.NDArray[np.float64]:
        """Contribution of each pair to the energy, (n,) float64."""
        return np.array([pair.cost for pair in self.correspondences], dtype=np.float64)


class Alternative(Correspondences):
    """Another good correspondence, often the reflection of the best one.

    Attributes
    ----------
    relation
        What it is, seen from the answer: ``"mirror_image"``, ``"rotation"``, ``"variation"`` if it
        differs in parts only, or ``"other"``; None in results of earlier versions.
    energy
        Energy of the labelling problem, (5) of the paper; with the objective ``"linf"`` the largest
        distortion.
    correspondences
        The matched pairs.
    distortion
        Their distortion.
    """

    relation: str | None = None

    def __repr__(self) -> str:
        kind = (self.relation or "alternative").replace("_", " ")
        return (
            f"<Alternative: {kind}, {len(self.correspondences)} points, energy {self.energy:.6g}>"
        )

    __str__ = __repr__


class Level(Answer):
    """One level of the coarse-to-fine matching, section 4.1 of the paper.

    Attributes
    ----------
    points, target_points
        Numbers of samples on the source and on the target.
    candidates
        Number of candidate pairs.
    metric, descriptor
        Names of the compared structures.
    energy, lower_bound, gap, iterations, method, seconds
        Solution, bound and cost of the solver.
    certified
        Whether no better correspondence exists among the candidates of this level.
    rank
        Rank of the solution by energy among it and its alternatives at this level, from 1.
    scope
        What the bound holds for: ``"samples"`` if all target samples of the level are candidates,
        else ``"candidates"``; None in results of earlier versions.
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
    scope: str | None = None


class SampleProof(Correspondences):
    """Least energy over all target samples of the finest level, with its certificate.

    Attributes
    ----------
    energy
        Least energy that is known over all samples.
    correspondences
        The correspondence of that energy, which may differ from the direct answer.
    distortion
        Its distortion.
    target_points
        Number of samples on the target.
    candidates
        Number of pairs of samples.
    lower_bound
        Lower bound of the energy of all correspondences of these samples.
    gap
        Relative difference of `energy` and `lower_bound`.
    certified
        Whether no better correspondence exists among all samples.
    regions
        Number of regions of the branch and bound.
    seconds
        Time of the proof.
    """

    target_points: int
    candidates: int
    lower_bound: FiniteFloat
    gap: FiniteFloat
    certified: bool
    regions: int
    seconds: FiniteFloat


class GromovHausdorff(Answer):
    """Gromov-Hausdorff distance of as many samples of either shape, with its certificate.

    Attributes
    ----------
    points
        Number of samples of either shape.
    value
        The distance if `certified`, else an upper bound.
    lower_bound
        Lower bound of the distance.
    gap
        Relative difference of `value` and `lower_bound`.
    certified
        Whether the value is the distance of the samples.
    correspondences
        The correspondence of that value, in which every sample of either shape is in one pair or
        more; costs are largest distortions.
    sampling_error
        The distance of the two sets of all vertices differs by at most this.
    seconds
        Time it took.
    """

    points: int
    value: FiniteFloat
    lower_bound: FiniteFloat
    gap: FiniteFloat
    certified: bool
    correspondences: tuple[Correspondence, ...]
    sampling_error: FiniteFloat
    seconds: FiniteFloat


class Overlap(Answer):
    """What two shapes have in common, one of which was matched as a part of the other, or both.

    Attributes
    ----------
    part
        ``"source"`` or ``"target"``: which is the part; ``"both"`` if each lacks points of the
        other.
    scale
        Factor from lengths of the source to lengths of the target.
    source, target
        Shares of their areas that have a partner on the other.
    """

    part: str
    scale: FiniteFloat
    source: FiniteFloat
    target: FiniteFloat

    def __str__(self) -> str:
        if self.part == "both":
            return (
                f"{self.source:.0%} of the source's area overlaps {self.target:.0%} of the target's"
            )
        whole, share = ("target", self.target) if self.part == "source" else ("source", self.source)
        return f"the {self.part} is a part of the {whole}, {share:.0%} of its area"


class InverseCorrespondence(Answer):
    """The map of all vertices of the target to the source.

    Attributes
    ----------
    target
        Vertex indices in the target's file, ascending: all vertices of the matched surface.
    source
        Vertex index in the source's file nearest to the preimage of each.
    faces
        Corners, as vertex indices in the source's file, of the triangle that holds each preimage.
    barycentric
        Barycentric coordinates of each preimage in its triangle, to four decimals.
    """

    target: tuple[int, ...]
    source: tuple[int, ...]
    faces: tuple[Annotated[tuple[int, ...], _OF_THREE], ...]
    barycentric: tuple[Annotated[tuple[FiniteFloat, ...], _OF_THREE], ...]

    def __repr__(self) -> str:
        return f"<InverseCorrespondence of {len(self.target)} vertices of the target>"

    __str__ = __repr__


class DenseCorrespondence(Answer):
    """A match extended to all vertices: of the source, and by `inverse` of the target.

    As arrays the two directions are :attr:`source_to_target` and :attr:`target_to_source`. Their
    rows are those of `source`, and of `target` of `inverse`; :meth:`isomatch.Match.vertex_map` has
    a row for each vertex of the file.

    Attributes
    ----------
    hypothesis
        Extended solution: 0 for the match's own pairs, j for ``alternatives[j - 1]`` if its map
        preserves more.
    source
        Vertex indices in the source's file, ascending: all vertices of the matched surface; where
        one shape was matched as a part, those that have a partner.
    target
        Vertex index in the target's file nearest to the image of each; not injective.
    faces
        Corners, as vertex indices in the target's file, of the triangle that holds each image.
    barycentric
        Barycentric coordinates of each image in its triangle, to four decimals. Like `faces` empty
        in results of services that gave vertices alone.
    inverse
        The other direction, from all vertices of the target to the source; None in results of
        services that gave one direction.
    """

    hypothesis: int
    source: tuple[int, ...]
    target: tuple[int, ...]
    faces: tuple[Annotated[tuple[int, ...], _OF_THREE], ...] = ()
    barycentric: tuple[Annotated[tuple[FiniteFloat, ...], _OF_THREE], ...] = ()
    inverse: InverseCorrespondence | None = None

    @cached_property
    def source_to_target(self) -> VertexMap:
        """Map of the source's vertices to points of the target."""
        return VertexMap(
            self.source_vertices, self.target_vertices, self.image_faces, self.image_weights
        )

    def __repr__(self) -> str:
        ways = "" if self.inverse is None else f", and of {len(self.inverse.target)} of the target"
        return f"<DenseCorrespondence of {len(self.source)} vertices of the source{ways}>"

    __str__ = __repr__

    @cached_property
    def target_to_source(self) -> VertexMap:
        """Map of the target's vertices to points of the source.

        Raises
        ------
        ValueError
            The service that computed the result gave one direction alone.
        """
        inverse = self.inverse
        if inverse is None:
            raise ValueError("the result has no map from the target to the source; match again")
        return VertexMap(
            np.array(inverse.target, dtype=np.int64),
            np.array(inverse.source, dtype=np.int64),
            np.array(inverse.faces, dtype=np.int64).reshape(-1, 3),
            np.array(inverse.barycentric, dtype=np.float64).reshape(-1, 3),
        )

    @cached_property
    def source_vertices(self) -> npt.NDArray[np.int64]:
        """`source` as an array, (K,) int64."""
        return np.array(self.source, dtype=np.int64)

    @cached_property
    def target_vertices(self) -> npt.NDArray[np.int64]:
        """`target` as an array, (K,) int64."""
        return np.array(self.target, dtype=np.int64)

    @cached_property
    def image_faces(self) -> npt.NDArray[np.int64]:
        """`faces` as an array, (K, 3) int64."""
        return np.array(self.faces, dtype=np.int64).reshape(-1, 3)

    @cached_property
    def image_weights(self) -> npt.NDArray[np.float64]:
        """`barycentric` as an array, (K, 3) float64."""
        return np.array(self.barycentric, dtype=np.float64).reshape(-1, 3)

    def interpolate(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Interpolate values of the target's vertices at the images: transfer them to the source.

        Parameters
        ----------
        values
            A value or a row for each vertex of the target's file, in its order: positions,
            colours, (V,) or (V, ...).

        Returns
        -------
        The value or row of each vertex in `source`, (K,) or (K, ...) float64.

        Raises
        ------
        ValueError
            `values` has fewer rows than the file, or the result has vertices alone.

        Examples
        --------
        >>> positions = match.dense.interpolate(target_vertices)  # (K, 3), of source_vertices
        """
        return self.source_to_target.interpolate(values)
