"""Landmarks in space: the points of a surface that they stand for, and those that are not on it."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from solver.arrays import BoolArray, FloatArray
from solver.errors import MisplacedLandmarks
from solver.mesh import SurfaceTree, TriangleMesh, surface_tree
from solver.transfer.landmarks import Landmarks

FAR: Final = 0.05
"""Distance from the surface, over √area, above which a landmark is left out."""

_BESIDE: Final = 0.01
"""Median distance, over √area, up to which landmarks are taken to be placed on the surface."""

_MOST_NAMED: Final = 5


@dataclass(frozen=True, eq=False)
class PlacedLandmarks:
    """Landmarks on the surface that they are of.

    Parameters
    ----------
    points
        The n nearest points of the surface, missing where a landmark is missing or far from it.
    from_surface
        (n,) distances of the landmarks from these, over √area; nan where one is missing.
    remarks
        Sentences for the user on landmarks that are not on the surface, and on labels that recur.
    """

    points: Landmarks
    from_surface: FloatArray
    remarks: tuple[str, ...]


def place_landmarks(
    labels: Sequence[str | None], positions: FloatArray, surface: TriangleMesh
) -> PlacedLandmarks:
    """Place landmarks on their surface.

    In the wrong coordinate system some landmarks are near the surface by chance, at wrong places.
    All are therefore refused if negated x and y (LPS for RAS) fit clearly better: fewer than half
    as many are far, and the median distance is less than half.

    Parameters
    ----------
    labels
        Names of the n landmarks in remarks and errors; of None, the number, from 0.
    positions
        (n, 3) in the coordinates of the surface; nan for a landmark that is missing.
    surface
        The surface.

    Raises
    ------
    MisplacedLandmarks
        All are far from the surface, or they are in another coordinate system.
    """
    present = np.flatnonzero(~np.isnan(positions[:, 0]))
    remarks = _recurring(labels)
    tree = surface_tree(surface.vertices, surface.faces)
    faces, barycentric = tree.nearest(positions[present])
    nearest = Landmarks(surface.vertex_ids[surface.faces[faces]], barycentric)
    from_surface = np.full(len(labels), np.nan)
    if len(present):
        named = [landmark_name(row, labels[row]) for row in present.tolist()]
        found = _Distances(named, positions[present], tree, float(np.sqrt(surface.area)))
        remarks += found.remarks()
        nearest, present = nearest.at(~found.far), present[~found.far]
        from_surface[present] = found.apart[~found.far]
    return PlacedLandmarks(Landmarks.at_rows(present, nearest, len(labels)), from_surface, remarks)


def landmark_name(place: int, label: str | None) -> str:
    """Return what messages call a landmark: its label, or else its number, from 0."""
    return f"number {place}" if label is None else repr(label)


def _recurring(labels: Sequence[str | None]) -> tuple[str, ...]:
    """A sentence for each label of several landmarks."""
    counts = Counter(label for label in labels if label is not None)
    return tuple(
        f"{count} landmarks are called {label!r}; only their order tells them apart"
        for label, count in counts.items()
        if count > 1
    )


@dataclass(frozen=True, eq=False)
class _Distances:
    """Distances of landmarks from a surface.

    Parameters
    ----------
    names
        Of the n landmarks, at least one.
    positions
        (n, 3).
    tree
        Of the surface.
    size
        Square root of its area.
    """

    names: Sequence[str]
    positions: FloatArray
    tree: SurfaceTree
    size: float

    @cached_property
    def apart(self) -> FloatArray:
        """(n,) over √area."""
        return self._apart(self.positions)

    @cached_property
    def negated(self) -> FloatArray:
        """(n,) over √area, with x and y negated."""
        return self._apart(self.positions * [-1.0, -1.0, 1.0])

    @cached_property
    def far(self) -> BoolArray:
        """(n,) whether each landmark is far from the surface."""
        return self.apart > FAR

    def remarks(self) -> tuple[str, ...]:
        """Return a sentence on landmarks that are far from the surface or beside it, if some are.

        Raises
        ------
        MisplacedLandmarks
            As for :func:`place_landmarks`.
        """
        middle = np.median(self.apart)
        off = middle > _BESIDE or bool(self.far.any())
        nearer = off and bool(np.median(self.negated) < 0.5 * middle)
        left = int((self.negated > FAR).sum()) if nearer else 0
        if nearer and 2 * left < self.far.sum():
            raise MisplacedLandmarks(
                f"{self._far()}, but {left or 'none'} with x and y negated: the landmarks are not"
                " in the coordinate system of the mesh (LPS or RAS)"
            )
        hint = ""
        if nearer and middle > _BESIDE:
            hint = "with x and y negated they are nearer: check the coordinate system (LPS or RAS)"
        if self.far.all():
            hint = hint or "check the unit of length and the coordinate system (LPS or RAS)"
            raise MisplacedLandmarks(f"{self._far()}: {hint}")
        if self.far.any():
            they = "it is" if self.far.sum() == 1 else "they are"
            return (f"{self._far()}; {they} left out" + (hint and f"; {hint}"),)
        return (f"the landmarks lie beside the surface; {hint}",) if hint else ()

    def _apart(self, positions: FloatArray) -> FloatArray:
        faces, weights = self.tree.nearest(positions)
        nearest = np.einsum("nc,ncd->nd", weights, self.tree.corners[faces])
        found: FloatArray = np.linalg.norm(positions - nearest, axis=1) / self.size
        return found

    def _far(self) -> str:
        """Return how many landmarks are far from the surface, and by how much the worst are."""
        worst = np.flatnonzero(self.far)
        worst = worst[np.argsort(-self.apart[worst], kind="stable")]
        named = [
            f"{self.names[row]} by {self.apart[row] * self.size:.4g}" for row in worst[:_MOST_NAMED]
        ]
        if len(worst) > _MOST_NAMED:
            named.append(f"and {len(worst) - _MOST_NAMED} more")
        be = "is" if len(worst) == 1 else "are"
        return (
            f"{len(worst)} of {len(self.apart)} landmarks {be} far from the surface, "
            + ", ".join(named)
        )
