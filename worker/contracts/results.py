"""The result of a match."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from worker.contracts.parameters import MatchParameters


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, allow_inf_nan=False)


class Correspondence(_Part):
    """One matched pair of vertices."""

    source: int = Field(description="0-based vertex index in the source's file.")
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

    energy: float = Field(description="Energy of the labelling problem, (5) of the paper.")
    correspondences: tuple[Correspondence, ...]
    distortion: Distortion


class Level(_Part):
    """One level of the coarse-to-fine matching, section 4.1 of the paper."""

    points: int = Field(description="Samples on the source.")
    target_points: int = Field(description="Samples on the target.")
    candidates: int = Field(description="Pairs of samples that were considered.")
    metric: str = Field(description="Metric that was compared.")
    descriptor: str = Field(description="Descriptor that was compared.")
    energy: float = Field(description="Energy of the best answer found.")
    lower_bound: float = Field(description="No answer of the level's problem has less energy.")
    gap: float = Field(description="Relative difference of the two.")
    certified: bool = Field(description="Whether the answer is proven to be the best.")
    iterations: int = Field(description="Steps of the solver.")
    method: str = Field(description="How the proof was made.")
    seconds: float = Field(description="Time the level took.")
    rank: int = Field(
        description="Place of the answer among all hypotheses by their energy at this level."
    )


class MatchResult(_Part):
    """A minimum-distortion correspondence, with what is proven of it."""

    version: Literal[1] = Field(default=1, description="Version of this format.")
    source: str = Field(description="Id of the source shape.")
    target: str = Field(description="Id of the target shape.")
    parameters: MatchParameters = Field(description="The parameters in force.")
    correspondences: tuple[Correspondence, ...] = Field(description="The matched pairs.")
    distortion: Distortion
    gromov_hausdorff: float = Field(
        description="Gromov-Hausdorff distance of the samples: half the largest distortion."
    )
    energy: float = Field(
        description="Energy of the labelling problem, (5) of the paper; with the objective"
        ' "linf" the largest distortion.'
    )
    lower_bound: float = Field(description="No correspondence of the problem solved has less.")
    gap: float = Field(description="Relative difference of `energy` and `lower_bound`.")
    certified: bool = Field(
        description="Whether the correspondence is proven to be the best of the problem solved."
    )
    alternatives: tuple[Alternative, ...] = Field(description="Other good correspondences.")
    levels: tuple[Level, ...] = Field(description="The levels, coarsest first.")
    unmatched: tuple[int, ...] = Field(
        description="Source vertices that are cheaper to leave unmatched."
    )
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(description='Seconds by stage, and "total".')
