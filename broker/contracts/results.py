"""The result of a match."""

from typing import Annotated, ClassVar, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.parameters import MatchParameters
from broker.contracts.result_document import ResultDocument

LIKELY_RIGHT: Final = 0.5
"""Probability of being right above which an answer is not in doubt: a coin toss is."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, allow_inf_nan=False)


class Correspondence(_Part):
    """One matched pair of vertices."""

    source: int = Field(
        description="0-based vertex index in the source's file; of a prototype, that of its point."
    )
    target: int = Field(description="0-based vertex index in the target's file.")
    cost: float = Field(
        description="What the pair contributes to the energy; with the objective"
        ' "linf" its largest distortion.'
    )


class Distortion(_Part):
    """Distortion of a correspondence C, section 2 of the paper; lengths on shapes of unit area."""

    first_order: float | None = Field(
        description="Sum of squared differences of descriptors over C; null without a descriptor."
    )
    second_order: float = Field(description="Sum of squared differences of distances over C × C.")
    linf: float = Field(description="Largest difference of distances.")


class Alternative(_Part):
    """Another good correspondence, often the mirror image of the best."""

    relation: Literal["mirror_image", "rotation", "variation", "other"] | None = Field(
        default=None,
        description="What it is, seen from the answer, by the orthogonal map of its points on the"
        ' target: "variation" if it differs in parts only. Null in results of earlier versions.',
    )
    energy: float = Field(description="Energy of the labelling problem, (5) of the paper.")
    correspondences: tuple[Correspondence, ...] = Field(description="Its pairs.")
    distortion: Distortion


class Level(_Part):
    """One level of the coarse-to-fine matching, section 4.1 of the paper."""

    points: int = Field(description="Samples on the source.")
    target_points: int = Field(description="Samples on the target.")
    candidates: int = Field(description="Pairs of samples that were considered.")
    metric: str = Field(
        description='Metric that was compared. "varadhan": Varadhan distances, by the heat kernel,'
        " by which the coarsest level's points are matched a second time."
    )
    descriptor: str = Field(description="Descriptor that was compared.")
    energy: float = Field(description="Energy of the best answer found.")
    lower_bound: float = Field(description="No answer of the level's problem has less energy.")
    gap: float = Field(description="Relative difference of the two.")
    certified: bool = Field(
        description="Whether the gap is at most 1e-4: no better correspondence among the candidates"
        " of this level."
    )
    iterations: int = Field(description="Steps of the solver.")
    method: str = Field(description="Method that found and bounded the answer.")
    seconds: float = Field(description="Time the level took.")
    rank: int = Field(
        description="Place of the answer by energy at this level, among the answer and its"
        " alternatives: 1 for the least energy."
    )
    scope: Literal["candidates", "samples"] | None = Field(
        default=None,
        description='Correspondences that the bound holds for: "samples" if all target samples of'
        ' the level are candidates, else "candidates". Null in results of earlier versions.',
    )


class SampleProof(_Part):
    """The least energy over all target samples of the finest level, with its certificate."""

    target_points: int = Field(description="Samples on the target.")
    candidates: int = Field(description="Pairs of samples: all that landmarks allow.")
    energy: float = Field(description="Least energy that is known over all samples.")
    lower_bound: float = Field(description="No correspondence of these samples has less energy.")
    gap: float = Field(description="Relative difference of the two.")
    certified: bool = Field(
        description="Whether the gap is at most 1e-4: no better correspondence among all samples."
    )
    correspondences: tuple[Correspondence, ...] = Field(
        description="The correspondence of that energy. It may differ from the direct answer, for"
        " instance by an intrinsic symmetry."
    )
    distortion: Distortion
    regions: int = Field(description="Regions of the branch and bound.")
    seconds: float = Field(description="Time the proof took.")


class GromovHausdorff(_Part):
    """Gromov-Hausdorff distance of the samples of both shapes, with its certificate.

    The sampled shapes are finite metric spaces, and every sample of either is in a pair or more.
    """

    points: int = Field(description="Samples on either shape.")
    value: float = Field(
        description="The distance if certified, else an upper bound: half of the largest"
        " distortion."
    )
    lower_bound: float = Field(description="No correspondence of these samples has less.")
    gap: float = Field(description="Relative difference of the two.")
    certified: bool = Field(
        description="Whether the gap is at most 1e-4: the value is the distance of the samples."
    )
    correspondences: tuple[Correspondence, ...] = Field(
        description="The correspondence of that value. A sample may be in several pairs; their"
        " cost is the largest distortion."
    )
    sampling_error: float = Field(
        description="The distance of the two sets of all vertices differs from that of the samples"
        " by at most this, the sum of the covering radii, as far as the triangle inequality holds."
    )
    seconds: float = Field(description="Time it took.")


class Overlap(_Part):
    """What two shapes have in common, one of which was matched as a part of the other, or both."""

    part: Literal["source", "target", "both"] = Field(
        description='Which of the shapes is the part; "both" if each lacks points of the other.'
    )
    scale: float = Field(
        gt=0, description="Factor from lengths of the source to lengths of the target."
    )
    source: float = Field(
        ge=0, le=1, description="Share of the source's area that has a partner on the target."
    )
    target: float = Field(
        ge=0, le=1, description="Share of the target's area that has a partner on the source."
    )


class Confidence(_Part):
    """How probably the answer is right, and reasons for doubt."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"probability": 0.97, "reasons": []},
                {"probability": 0.31, "reasons": ["the mirror image fits nearly as well"]},
            ]
        }
    )

    probability: float = Field(
        ge=0,
        le=1,
        description="Calibrated probability that the answer is right: that its mean geodesic error"
        " is below a tenth of the square root of the area. Up to one half the answer is in doubt.",
    )
    reasons: tuple[str, ...] = Field(description="Reasons for doubt, in words; empty if none.")

    @property
    def in_doubt(self) -> bool:
        """Whether the answer is not more probably right than wrong."""
        return self.probability <= LIKELY_RIGHT


class RefinedPoint(_Part):
    """A point of the target's surface, between three vertices that make a triangle there."""

    source: int = Field(description="0-based vertex index in the source's file.")
    vertices: Annotated[tuple[int, ...], Field(min_length=3, max_length=3)] = Field(
        description="0-based indices, in the target's file, of the triangle's corners. Of a shape"
        " that was simplified it is a triangle of fewer, larger ones, whose corners are vertices of"
        " the file all the same."
    )
    weights: Annotated[
        tuple[Annotated[float, Field(ge=0, le=1)], ...], Field(min_length=3, max_length=3)
    ] = Field(
        description="Barycentric coordinates, none negative, of sum 1: the point is the mean of"
        " the corners with these weights."
    )


class Refinement(_Part):
    """Positions of the matched points between the target's vertices: GMDS, (7) and 7.1."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "hypothesis": 0,
                    "stress": 0.31,
                    "initial_stress": 0.47,
                    "status": "converged",
                    "points": [
                        {"source": 17, "vertices": [204, 31, 205], "weights": [0.25, 0.0, 0.75]}
                    ],
                }
            ]
        }
    )

    hypothesis: int = Field(
        ge=0,
        description='What was refined: 0 for `correspondences`. With objective "linf", whose'
        " answer is that of least distortion whatever its extension is like, it may be j for the"
        " j-th of `alternatives`; the points are then near its pairs.",
    )
    stress: float = Field(
        ge=0,
        description="Sum of squared differences of distances, near ones weighing most, among these"
        " points and others between them; in units of the target's area.",
    )
    initial_stress: float = Field(ge=0, description="The same before GMDS; never less.")
    status: Literal["converged", "iterations", "deadline"] = Field(description="Why it ended.")
    points: tuple[RefinedPoint, ...] = Field(
        description="One for each of `correspondences`, in their order."
    )


_OF_THREE: Final = Field(min_length=3, max_length=3)
_Triangle = Annotated[tuple[int, ...], _OF_THREE]
_Weights = Annotated[tuple[Annotated[float, Field(ge=0, le=1)], ...], _OF_THREE]


class InverseCorrespondence(_Part):
    """The map of all vertices of the target's surface to the source; all lists are as long."""

    target: tuple[int, ...] = Field(
        description="0-based vertex indices in the target's file, ascending: all that the matched"
        " surface has."
    )
    source: tuple[int, ...] = Field(
        description="The vertex of the source's file that is nearest to the preimage of each."
    )
    faces: tuple[_Triangle, ...] = Field(
        description="The corners, 0-based vertex indices in the source's file, of the triangle in"
        " which the preimage of each of them lies."
    )
    barycentric: tuple[_Weights, ...] = Field(
        description="Barycentric coordinates of the preimages in these triangles, none negative, of"
        " sum 1, to four decimals."
    )


class DenseCorrespondence(_Part):
    """A map of all vertices of the source's surface; all lists are of the same length."""

    hypothesis: int = Field(
        ge=0,
        description='What was extended: 0 for `correspondences`. With objective "linf", whose'
        " answer is that of least distortion whatever its extension is like, it may be j for the"
        " j-th of `alternatives`.",
    )
    source: tuple[int, ...] = Field(
        description="0-based vertex indices in the source's file, ascending: all that the matched"
        " surface has. Vertices of no face or of another component are not among them; one that"
        " `simplify` has removed goes where the one that stands for it does."
    )
    target: tuple[int, ...] = Field(
        description="The vertex of the target's file that is nearest to the image of each of them;"
        " several may go to one."
    )
    faces: tuple[_Triangle, ...] = Field(
        default=(),
        description="The corners, 0-based vertex indices in the target's file, of the triangle in"
        " which the image of each of them lies. Of a shape that was simplified it is a triangle of"
        " fewer, larger ones. Empty in results of versions that gave vertices alone.",
    )
    barycentric: tuple[_Weights, ...] = Field(
        default=(),
        description="Barycentric coordinates of the images in these triangles, none negative, of"
        " sum 1, to four decimals.",
    )
    inverse: InverseCorrespondence | None = Field(
        default=None,
        description="The other direction: all vertices of the target, and the points of the source"
        " that they correspond to. Null in results of versions that gave one direction.",
    )


class MatchResult(ResultDocument):
    """A minimum-distortion correspondence, with what is proven of it."""

    ADDED: ClassVar = frozenset(
        {
            "source_name",
            "target_name",
            "source_file_vertices",
            "target_file_vertices",
            "confidence",
            "proof",
            "gromov_hausdorff_distance",
            "overlap",
        }
    )

    kind: Literal["match"] = Field(default="match", description="Kind of the job.")
    source: str = Field(description="Id of the source: a shape, or a prototype.")
    source_kind: Literal["shape", "prototype"] = Field(
        default="shape",
        description="What the source is. Of a prototype, points are named by their numbers from 0"
        " where vertices of a shape are.",
    )
    target: str = Field(description="Id of the target shape.")
    source_name: str | None = Field(
        default=None, description="Name of the source; null in results of earlier versions."
    )
    target_name: str | None = Field(
        default=None, description="Name of the target; null in results of earlier versions."
    )
    source_file_vertices: int | None = Field(
        default=None,
        description="Number of vertices of the source's file; null for a prototype, and in results"
        " of earlier versions.",
    )
    target_file_vertices: int | None = Field(
        default=None,
        description="Number of vertices of the target's file; null in results of earlier versions.",
    )
    parameters: MatchParameters = Field(description="The parameters in force.")
    correspondences: tuple[Correspondence, ...] = Field(description="The matched pairs.")
    distortion: Distortion
    gromov_hausdorff: float = Field(
        description="Upper bound of the Gromov-Hausdorff distance of the matched points: half the"
        " largest distortion. `gromov_hausdorff_distance` has that of the samples."
    )
    energy: float = Field(
        description="Energy of the labelling problem, (5) of the paper; with the objective"
        ' "linf" the largest distortion.'
    )
    lower_bound: float = Field(description="No correspondence of the problem solved has less.")
    gap: float = Field(description="Relative difference of `energy` and `lower_bound`.")
    certified: bool = Field(
        description="Whether the gap is at most 1e-4: no better correspondence among the candidates"
        " of the finest level. It says nothing of other points, and not that the answer is right:"
        " see `confidence`."
    )
    confidence: Confidence | None = Field(
        default=None,
        description="How probably the answer is right, and reasons for doubt; null where the"
        " surfaces were not registered: `orientation` false without `dense` and `refine`, objective"
        ' "linf", or a prototype.',
    )
    alternatives: tuple[Alternative, ...] = Field(
        description="Other good correspondences, the likeliest first; some may have less energy,"
        " where the rest of the surface agrees better with the answer, or orientation chose it."
    )
    levels: tuple[Level, ...] = Field(description="The levels, coarsest first.")
    proof: SampleProof | None = Field(
        default=None,
        description="The least energy over all target samples of the finest level. `certified`"
        " compares the answer with two or three of them for each point, or up to twelve if nothing"
        " was registered; this, with all. Null with"
        ' `proof` "candidates", with a prototype, with the objective "linf", and of too many'
        " samples.",
    )
    gromov_hausdorff_distance: GromovHausdorff | None = Field(
        default=None,
        description='With the objective "linf", the Gromov-Hausdorff distance of as many samples of'
        ' either shape; null with another objective, and with `proof` "candidates".',
    )
    overlap: Overlap | None = Field(
        default=None,
        description="What the shapes have in common, where one was matched as a part of the other,"
        " or both as parts, see `partial`; null where both were matched as wholes. `dense` then has"
        " only vertices that have a partner.",
    )
    unmatched: tuple[int, ...] = Field(
        description="Source vertices (or points) that are cheaper to leave unmatched, or have no"
        " partner on a part."
    )
    refinement: Refinement | None = Field(
        default=None,
        description="The matched points between the target's vertices; null if that was not asked"
        " for, or if a shape has fewer than four vertices, too few to be registered.",
    )
    dense: DenseCorrespondence | None = Field(
        default=None,
        description="The match extended to all vertices; null if that was not asked for, or if"
        " a shape has fewer than four vertices, too few to be registered.",
    )
    misfit: FiniteFloat | None = Field(
        default=None,
        description="Of a prototype, how much the target misfits its class: the energy per point at"
        " the coarsest level, divided by the usual energy of examples left out in cross-validation;"
        " 1 is usual. A warning says that the misfit exceeds that of every example left out: by a"
        " sixth of 24 of these, twofold of four."
        " Null of two shapes, of prototypes of fewer than four examples, and where `beta`,"
        " `first_order_weight`, `occlusion_cost`, `oversampling` or the points of the coarsest"
        " level are not those by default, or the least energy there is not proven in time.",
    )
    warnings: tuple[str, ...] = Field(
        description="Repairs of the meshes, limits that were reached, and doubts."
    )
    timings: dict[str, FiniteFloat] = Field(description='Seconds by stage, and "total".')
