"""Results that come with arrays, which are requested with the document."""

import io
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import PrivateAttr

from isomatch._results.result_document import Result


class ArrayResult(Result):
    """A result document with its arrays."""

    _archive: bytes | None = PrivateAttr(default=None)

    def held(self, ending: str) -> bytes | None:
        """Return the document or, as "npz", the arrays, which need no request."""
        return self._archive if ending == "npz" else super().held(ending)

    @cached_property
    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Arrays of the result by name, as :meth:`isomatch.Job.save_arrays` writes them.

        Raises
        ------
        ValueError
            The result was read from a file, which has no arrays.
        """
        if self._archive is None:
            raise ValueError("a result read from a file has no arrays; request it from the service")
        with np.load(io.BytesIO(self._archive), allow_pickle=False) as arrays:
            return dict(arrays)
