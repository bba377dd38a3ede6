"""The problem document (RFC 9457) in which the service says what went wrong."""

import re

from pydantic import BaseModel, ConfigDict


class FieldProblem(BaseModel):
    """What is wrong with one field of a request.

    Attributes
    ----------
    field
        Where the field is, such as ``body.points``.
    message
        What is wrong with it.
    """

    model_config = ConfigDict(frozen=True)

    field: str
    message: str


class Problem(BaseModel):
    """A problem document.

    Attributes
    ----------
    type
        URI that names the kind of problem.
    title
        The kind of problem in words.
    status
        HTTP status.
    detail
        This occurrence of it in words.
    instance
        What it happened to.
    errors
        What is wrong with which field, where fields are to blame.
    """

    model_config = ConfigDict(frozen=True)

    type: str = "about:blank"
    title: str
    status: int
    detail: str | None = None
    instance: str | None = None
    errors: tuple[FieldProblem, ...] = ()

    @property
    def summary(self) -> str:
        """The document in one line."""
        line = self.detail or self.title
        fields = [f"{error.field.removeprefix('body.')}: {error.message}" for error in self.errors]
        if all(field in line for field in fields):
            return line
        # Where to look in the document is of no use to those who see no document.
        line = re.sub(r"; `errors` says [a-z ]+\.?$", "", line)
        return f"{line.rstrip('.:')}: {'; '.join(fields)}"
