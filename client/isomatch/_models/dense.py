"""A match extended to all vertices."""

from functools import cached_property

import numpy as np
import numpy.typing as npt

from isomatch._models.models import Answer


class DenseCorrespondence(Answer):
    """A map of all vertices of the source's surface.

    Attributes
    ----------
    hypothesis
        What was extended: 0 for the match's own pairs, j for ``alternatives[j - 1]``, if the map
        that this leads to preserves more.
    source
        Vertex indices in the source's file, ascending: all that the matched surface has.
    target
        The vertex of the target's file that each corresponds to; several may go to one.
    """

    hypothesis: int
    source: tuple[int, ...]
    target: tuple[int, ...]

    @cached_property
    def source_vertices(self) -> npt.NDArray[np.int64]:
        """The same as an array, shape (K,), int64."""
        return np.array(self.source, dtype=np.int64)

    @cached_property
    def target_vertices(self) -> npt.NDArray[np.int64]:
        """The same as an array, shape (K,), int64."""
        return np.array(self.target, dtype=np.int64)
