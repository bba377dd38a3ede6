"""Errors of the solver.

::

    SolverError
    ├── MeshError       a mesh cannot be read or computed on
    ├── OptionError     the value of an option is invalid, alone or with this shape
    ├── PrototypeError  an archive is no valid prototype, or examples cannot be learned
    ├── TransferError   attributes cannot be read, carried or written
    │   └── MisplacedLandmarks  landmarks are not on their surface
    └── Cancelled       the caller asked to stop before there was an answer
"""


class SolverError(Exception):
    """Root of the errors of the solver; their messages may be shown to users."""


class MeshError(SolverError):
    """A mesh cannot be read or computed on."""


class OptionError(SolverError):
    """The value of an option is invalid, alone or with this shape.

    Parameters
    ----------
    field
        Name of the option.
    message
        What is wrong with its value, and what is allowed.
    """

    def __init__(self, field: str, message: str) -> None:
        super().__init__(message)
        self.field = field
        self.message = message

    def __str__(self) -> str:
        return f"{self.field}: {self.message}"


class PrototypeError(SolverError):
    """An archive is no valid prototype, or examples cannot be learned."""


class TransferError(SolverError):
    """Attributes of a shape cannot be read, carried to another, or written."""


class MisplacedLandmarks(TransferError):
    """Landmarks have another unit of length or coordinate system than their surface."""


class Cancelled(SolverError):
    """The caller asked to stop before there was an answer."""
