"""Problem documents (RFC 9457), the errors of the service."""

import re

from pydantic import BaseModel, ConfigDict


class FieldProblem(BaseModel):
    """An invalid field of a request.

    Attributes
    ----------
    field
        Path of the field, such as ``body.points``.
    message
        Description of the error.
    pointer
        JSON pointer (RFC 6901) to the field in the body of the request, such as ``/points``; None
        for other parts of the request, and of services of earlier versions.
    """

    model_config = ConfigDict(frozen=True)

    field: str
    message: str
    pointer: str | None = None


class Problem(BaseModel):
    """A problem document.

    Attributes
    ----------
    type
        URI of the kind of problem.
    title
        Name of the kind of problem.
    status
        HTTP status.
    detail
        Description of this occurrence.
    instance
        Resource concerned.
    errors
        Invalid fields of the request, if any.
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
        """The document in one line, without errors of fields that `detail` has already."""
        line = self.detail or self.title
        fields = [
            f"{error.field.removeprefix('body.')}: {error.message}"
            for error in self.errors
            if error.message not in line
        ]
        if not fields:
            return line
        # A reference to the document's `errors` is of no use in a line that contains them.
        line = re.sub(r"; `errors` says [a-z ]+\.?$", "", line)
        return f"{line.rstrip('.:')}: {'; '.join(fields)}"
