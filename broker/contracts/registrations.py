"""Template registrations: one template on many specimens, and the statistics of their shapes."""

from typing import ClassVar, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from broker.contracts.result_document import ResultDocument
from broker.contracts.results import Confidence
from broker.contracts.shapes import UPRIGHT, ViewAxes

MOST_SPECIMENS: Final = 256
"""Greatest number of specimens of a registration."""

MOST_REGISTERED: Final = 4_000_000
"""Greatest number of vertices of all registered templates: each is kept twice, in 48 bytes."""


class SpecimenReport(BaseModel):
    """One specimen of a registration; the measures are null if it was not registered."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    shape: str = Field(description="Id of the specimen.")
    name: str | None = Field(description="Its name.")
    registered: bool = Field(description="Whether the template was registered to it.")
    reason: str | None = Field(description="Why not; null if it was.")
    confidence: Confidence | None = Field(
        description="Confidence of the match of the template with the specimen."
    )
    mean_distance: FiniteFloat | None = Field(
        description="Mean distance between the registered template and the specimen, over the"
        " square root of the specimen's area: the greater of the means over the centres of the"
        " template's triangles, from the specimen, and over the specimen's vertices, from the"
        " template."
    )
    max_distance: FiniteFloat | None = Field(
        description="Greatest of these distances: large where the template leaves a part of the"
        " specimen uncovered, or its triangles cross the inside."
    )
    flipped: int | None = Field(
        description="Number of flipped triangles: their normals make more than a right angle with"
        " that of the specimen's triangle nearest to their centre."
    )
    reflected: bool | None = Field(description="Whether the template is reflected in space.")
    scores: tuple[FiniteFloat, ...] = Field(
        description="Coordinates of its shape in the principal components, in the unit of length."
    )


class PrincipalComponent(BaseModel):
    """One principal component of the specimens' shapes."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    variance: FiniteFloat = Field(description="Variance of the scores, in squared units of length.")
    explained: FiniteFloat = Field(description="Its share in the variance of all coordinates.")


class RegistrationResult(ResultDocument):
    """A template registered to specimens, and the statistics of their shapes."""

    ADDED: ClassVar = frozenset({"view"})

    kind: Literal["registration"] = Field(default="registration", description="Kind of the job.")
    template: str = Field(description="Id of the template.")
    template_name: str | None = Field(description="Its name.")
    vertices: int = Field(description="Number of vertices that all registered templates have.")
    faces: int = Field(description="Number of their triangles, which are those of the template.")
    scale: bool = Field(description="Whether the specimens were scaled to a common size.")
    specimens: tuple[SpecimenReport, ...] = Field(
        description="The specimens, in the order in which they were given."
    )
    components: tuple[PrincipalComponent, ...] = Field(
        description="Principal components, by falling variance: one fewer than registered"
        " specimens, but for directions in which these differ only by rounding errors."
    )
    view: ViewAxes = Field(
        default=UPRIGHT,
        description="How the page and the picture show the mean shape: as the template stands. In"
        " results of earlier versions, y is up.",
    )
    warnings: tuple[str, ...] = Field(description="What should be known about this answer.")
    timings: dict[str, FiniteFloat] = Field(description='Seconds by stage, and "total".')
