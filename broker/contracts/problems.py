"""Problem documents (RFC 9457), the form of all errors."""

from typing import Self

from pydantic import BaseModel, ConfigDict, Field

URN = "urn:isomatch:problem:"


class FieldProblem(BaseModel):
    """Problem with one field of a request."""

    model_config = ConfigDict(frozen=True)

    field: str = Field(description="Where the field is.", examples=["body.points"])
    message: str = Field(description="What is wrong with its value.")


class Problem(BaseModel):
    """A problem document (RFC 9457)."""

    model_config = ConfigDict(frozen=True)

    type: str = Field(
        description="URI that names the kind of problem.", examples=[URN + "unknown-shape"]
    )
    title: str = Field(description="The kind of problem in words.")
    status: int = Field(description="HTTP status.")
    detail: str = Field(description="This occurrence of it in words, and what to do about it.")
    instance: str | None = Field(default=None, description="What it happened to.")
    errors: tuple[FieldProblem, ...] = Field(
        default=(), description="What is wrong with which field, where fields are to blame."
    )

    @classmethod
    def of(
        cls,
        slug: str,
        title: str,
        status: int,
        detail: str,
        errors: tuple[FieldProblem, ...] = (),
        instance: str | None = None,
    ) -> Self:
        """Return the problem of the kind `slug`."""
        return cls(
            type=URN + slug,
            title=title,
            status=status,
            detail=detail,
            errors=errors,
            instance=instance,
        )

    @property
    def slug(self) -> str:
        """Name of the kind of problem, the last part of its type."""
        return self.type.removeprefix(URN)
