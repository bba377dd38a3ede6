"""What the solver raises.

::

    SolverError
    ├── MeshError       a mesh cannot be read, or no sound answer can be computed on it
    ├── OptionError     an option's value has no meaning, alone or with this shape
    ├── PrototypeError  an archive is no prototype, or examples make none
    └── Cancelled       the caller asked to stop and there is no answer yet
"""


class SolverError(Exception):
    """Root of the errors the solver raises on purpose; the message is fit for a user."""


class MeshError(SolverError):
    """A mesh cannot be read, or no sound answer can be computed on it."""


class OptionError(SolverError):
    """An option's value has no meaning, alone or with this shape.

    Parameters
    ----------
    field
        Name of the option.
    message
        What is wrong with its value, and what would be right.
    """

    def __init__(self, field: str, message: str) -> None:
        super().__init__(message)
        self.field = field
        self.message = message

    def __str__(self) -> str:
        return f"{self.field}: {self.message}"


class PrototypeError(SolverError):
    """An archive is no prototype, or examples make none."""


class Cancelled(SolverError):  # noqa: N818 - a request, not a fault
    """The caller asked to stop and there is no answer yet."""
