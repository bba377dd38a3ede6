"""Comparing a collection of shapes: how, and what comes of it."""

import hashlib
from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationInfo, field_validator

from broker.contracts.descriptors import Descriptor, descriptor_choice
from broker.contracts.metrics import Metric, metric_choice
from broker.contracts.parameters import ObjectiveName
from broker.contracts.spectra import SpectrumKey
from broker.contracts.structures import Choice

SIGNATURE_VERSION: Final = 1
"""Raised whenever the solver's signatures change, so that no stale one is taken from a cache."""

MOST_SHAPES: Final = 2000
"""Shapes that are compared at a time: a matrix of so many is some forty megabytes of JSON."""

STRUCTURES, PAIRS, RESULT = "structures", "pairs", "result"
STAGES: Final = (STRUCTURES, PAIRS, RESULT)
"""Stages of the job: signatures of the shapes, ranges of pairs, and the result, which is one part.
"""

NEIGHBOURS: Final = 10
"""Nearest neighbours that are listed of each shape."""


class DissimilarityParameters(BaseModel):
    """How shapes are compared; everything has a default that is meant to be good.

    Section and equation numbers are those of Wang, Bronstein and Paragios, INRIA RR-7333, 2010.
    Distances are taken on shapes of unit area.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    points: int = Field(
        default=6,
        ge=3,
        le=10,
        description="Points of each shape, all of which are matched, to proven optimality.",
    )
    metric: Metric = Field(
        default="commute_time",
        description="Distance whose distortion is measured: the name of a metric, or an object of"
        " its name and its parameters; `GET /v1/structures` lists them.",
        examples=["geodesic", {"name": "diffusion", "time": 0.02}],
    )
    descriptor: Descriptor = Field(
        default="si_hks",
        description="Local descriptor of the first-order term, given like `metric`. Without a"
        " `first_order_weight` it is not looked at. Of eigenfunctions, magnitudes are compared.",
        examples=["hks"],
    )
    first_order_weight: float = Field(
        default=0.0, ge=0, le=1e6, description="Weight of the first-order (descriptor) term."
    )
    objective: ObjectiveName = Field(
        default="l2",
        description='What the dissimilarity of two shapes is: "l2", the least energy (5) of a'
        ' matched point, or "linf", the least greatest distortion of a distance, twice the'
        " Gromov-Hausdorff distance of the matched points, which knows no first-order term.",
    )
    eigenpairs: int = Field(
        default=100,
        ge=10,
        le=300,
        description="Eigenpairs of the Laplace-Beltrami operator.",
    )
    largest_component: bool = Field(
        default=False,
        description="Compare the largest component of a shape that has several, which is refused"
        " otherwise.",
    )
    simplify: int | None = Field(
        default=None,
        ge=100,
        le=1_000_000,
        description="Vertices to which a shape that has more is simplified first; null for no"
        " simplification.",
    )

    @field_validator("objective")
    @classmethod
    def _suits_the_objective(cls, value: str, info: ValidationInfo) -> str:
        if value == "linf" and (info.data.get("first_order_weight") or 0.0) > 0.0:
            raise ValueError('"linf" knows no first-order term; leave `first_order_weight` out')
        return value

    @property
    def metrics(self) -> tuple[Choice]:
        """The metric with its parameters."""
        return (metric_choice(self.metric),)

    @property
    def descriptors(self) -> tuple[Choice]:
        """The descriptor with its parameters."""
        return (descriptor_choice(self.descriptor),)

    @property
    def spectrum_size(self) -> int:
        """Eigenpairs that are computed of each shape."""
        return self.eigenpairs

    def signature_name(self, key: SpectrumKey) -> str:
        """Return what a signature is cached by: all that it depends on, which `points` is not.

        Parameters
        ----------
        key
            Name of the shape's spectrum.
        """
        described = self.descriptors if self.first_order_weight > 0.0 else ()
        texts = [choice.model_dump_json() for choice in (*self.metrics, *described)]
        digest = hashlib.sha256("|".join(texts).encode()).hexdigest()[:16]
        return f"{key}:signature:{digest}:v{SIGNATURE_VERSION}"


class DissimilarityResult(BaseModel):
    """Dissimilarities among the shapes of a collection, each the least of its kind, and proven."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    version: Literal[1] = Field(default=1, description="Version of this format.")
    shapes: tuple[str, ...] = Field(description="Ids of the shapes, K of them, as they were given.")
    labels: tuple[str, ...] | None = Field(description="Their labels, if any were given.")
    parameters: DissimilarityParameters = Field(description="The parameters in force.")
    matrix: tuple[tuple[FiniteFloat, ...], ...] = Field(
        description="Dissimilarities, K rows of K: symmetric, 0 on the diagonal."
    )
    lower_bounds: tuple[FiniteFloat, ...] = Field(
        description="What the distortion of each pair of shapes is at least, for the pairs (0, 1),"
        " (0, 2), ..., (1, 2), ...: the upper triangle of `matrix`, row by row."
    )
    certified: bool = Field(description="Whether every dissimilarity is proven to be the least.")
    uncertified: tuple[tuple[int, int], ...] = Field(
        description="Pairs of shapes, by their places, of which that is not proven."
    )
    nearest: tuple[tuple[int, ...], ...] = Field(
        description=f"Places of the nearest other shapes of each, at most {NEIGHBOURS}, the least"
        " dissimilar first."
    )
    mean_average_precision: FiniteFloat | None = Field(
        description="Mean over the shapes of their average precision: each shape ranks all others"
        " by dissimilarity, and those of its label should come first. Null without labels, or"
        " where no two shapes have the same."
    )
    precision_at_1: FiniteFloat | None = Field(
        description="Share of the shapes whose nearest other shape has the same label; null"
        " likewise."
    )
    average_precisions: tuple[FiniteFloat | None, ...] | None = Field(
        description="Average precision of each shape; null for one that is alone with its label."
    )
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(
        description='Seconds of all workers by stage, and "total", the seconds from the start.'
    )
