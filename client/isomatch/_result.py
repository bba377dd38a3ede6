"""What all results have in common: the document they are read from."""

import os
from pathlib import Path
from typing import Self

from pydantic import PrivateAttr

from isomatch._models import Answer


class Result(Answer):
    """A result document of the service, with its contents as typed values."""

    _document: bytes | None = PrivateAttr(default=None)

    @classmethod
    def from_json(cls, document: bytes | str) -> Self:
        """Read a result document, as the service answers it or :meth:`save` wrote it.

        Raises
        ------
        pydantic.ValidationError
            It is not a result document.
        """
        result = cls.model_validate_json(document)
        result._document = document.encode() if isinstance(document, str) else document
        return result

    def to_json(self) -> bytes:
        """Return the result document exactly as the service sent it."""
        return self._document or self.model_dump_json().encode()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result document to a file, exactly as the service sent it.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        Path(path).write_bytes(self.to_json())
