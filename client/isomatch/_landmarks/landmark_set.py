"""Landmarks of one specimen: named positions in space, of which some may be missing."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class LandmarkSet:
    """Landmarks of a specimen, in the coordinates of its mesh file.

    Attributes
    ----------
    labels
        Name of each landmark, n of them.
    positions
        Positions, (n, 3), kept as float64; a row of nan for a landmark that is missing.
    name
        Name of the specimen; empty if it has none.
    descriptions
        A remark on each landmark, for formats that have them; none by default.

    Raises
    ------
    ValueError
        The numbers of labels, positions and descriptions differ, or a position is not finite.
    """

    labels: tuple[str, ...]
    positions: npt.NDArray[np.float64]
    name: str = ""
    descriptions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", np.asarray(self.positions, dtype=np.float64))
        if self.positions.shape != (len(self.labels), 3):
            raise ValueError(
                f"{len(self.labels)} landmarks have positions of shape ({len(self.labels)}, 3),"
                f" not {self.positions.shape}"
            )
        if self.descriptions and len(self.descriptions) != len(self.labels):
            raise ValueError("give a description for each landmark, or none")
        wrong = ~np.isfinite(self.positions).all(axis=1) & ~np.isnan(self.positions).all(axis=1)
        if wrong.any():
            raise ValueError(
                f"landmark {self.labels[int(wrong.argmax())]!r} has a coordinate that is not finite"
            )

    def __repr__(self) -> str:
        return f"<LandmarkSet of {len(self)} landmarks{self.name and f' of {self.name!r}'}>"

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def present(self) -> npt.NDArray[np.bool_]:
        """Whether each landmark has a position, (n,) bool."""
        return ~np.isnan(self.positions[:, 0])

    @classmethod
    def of(
        cls,
        rows: Sequence[tuple[str, Sequence[float] | None]],
        name: str = "",
        descriptions: tuple[str, ...] = (),
    ) -> "LandmarkSet":
        """Return landmarks of labels and positions, of which None stands for a missing one."""
        places = [(np.nan,) * 3 if place is None else tuple(place) for _, place in rows]
        positions = np.array(places, dtype=np.float64).reshape(-1, 3)
        return cls(tuple(label for label, _ in rows), positions, name, descriptions)

    def flipped(self) -> "LandmarkSet":
        """Return the landmarks with x and y negated: RAS as LPS, and LPS as RAS."""
        turned = self.positions * np.array([-1.0, -1.0, 1.0])
        return LandmarkSet(self.labels, turned, self.name, self.descriptions)
