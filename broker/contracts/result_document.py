"""Base of the results of jobs."""

from typing import Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler
from pydantic_core import CoreSchema


class ResultDocument(BaseModel):
    """Result of a job: a document that is sent to callers exactly as it was stored.

    Each kind of results has a field `kind`, by which they are told apart.
    """

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    ADDED: ClassVar[frozenset[str]] = frozenset()
    """Fields besides `kind` and `job` that results stored by earlier versions lack. The schema
    requires all others: every result has them, those with defaults too."""

    version: Literal[1] = Field(default=1, description="Version of this format.")
    job: str | None = Field(
        default=None,
        description="Id of the job; missing, as `kind` is, in results of earlier versions, until"
        " they expire.",
    )

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the schema, which requires what every stored result has."""
        reference = handler(core_schema)
        schema = handler.resolve_ref_schema(reference)
        late = cls.ADDED | {"kind", "job"}
        schema["required"] = [name for name in schema["properties"] if name not in late]
        return reference
