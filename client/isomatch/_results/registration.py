"""Templates registered to specimens, and the statistics of the specimens' shapes."""

import csv
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import FiniteFloat

from isomatch._models import UPRIGHT, Answer, Confidence, ViewAxes
from isomatch._results.array_result import ArrayResult
from isomatch._results.result_document import Drawable
from isomatch._results.summary import called, screen
from isomatch._upload import binary_ply

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

Floats = npt.NDArray[np.float64]

_SHOWN = 5
"""Components that are printed."""


class Specimen(Answer):
    """One specimen of a registration; the measures are None if it was not registered.

    Attributes
    ----------
    shape, name
        Id and name of the specimen.
    registered
        Whether the template was registered to it.
    reason
        Why not; None if it was.
    confidence
        Confidence of the match of the template with the specimen.
    mean_distance, max_distance
        Between the registered template and the specimen, over the square root of the specimen's
        area: the greater of the means over the centres of the template's triangles, from the
        specimen, and over the specimen's vertices, from the template; and the greatest of all.
    flipped
        Number of flipped triangles.
    reflected
        Whether the template is reflected in space.
    scores
        Coordinates in the principal components, in the unit of length.
    """

    shape: str
    name: str | None
    registered: bool
    reason: str | None
    confidence: Confidence | None
    mean_distance: FiniteFloat | None
    max_distance: FiniteFloat | None
    flipped: int | None
    reflected: bool | None
    scores: tuple[FiniteFloat, ...]


class PrincipalComponent(Answer):
    """A principal component of the specimens' shapes.

    Attributes
    ----------
    variance
        Variance of the scores, in squared units of length.
    explained
        Its share in the variance of all coordinates.
    """

    variance: FiniteFloat
    explained: FiniteFloat


class Registration(ArrayResult):
    """A template registered to specimens, and the statistics of their shapes.

    Row i of the arrays is vertex i of the template's file. They are those of the M registered
    specimens, in the order of :attr:`specimens`.

    Attributes
    ----------
    version
        Version of the result format.
    template, template_name
        Id and name of the template.
    vertices
        Number W of vertices.
    scale
        Whether the specimens were scaled to a common size.
    specimens
        All specimens, in the order in which they were given.
    components
        Principal components, by falling variance.
    view
        Directions to the right, up and towards the viewer in figures: those of the template.
    warnings
        Remarks of the service on this result.
    timings
        Seconds by stage, and ``"total"``.
    """

    version: int = 1
    template: str
    template_name: str | None
    vertices: int
    scale: bool
    specimens: tuple[Specimen, ...]
    components: tuple[PrincipalComponent, ...]
    view: ViewAxes = UPRIGHT
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        done = sum(one.registered for one in self.specimens)
        return f"<Registration of {done} of {len(self.specimens)} specimens>"

    def __str__(self) -> str:
        done = sum(one.registered for one in self.specimens)
        specimens = ((one.name, one.shape) for one in self.specimens)
        template, *names = called([(self.template_name, self.template), *specimens])
        heading = f"{template} registered to {done} of {len(self.specimens)} specimens"
        shares = ", ".join(f"{100.0 * one.explained:.0f} %" for one in self.components[:_SHOWN])
        if shares:
            heading += f"; variance of the components: {shares}"
        return screen(heading, list(map(_line, self.specimens, names)))

    @property
    def faces(self) -> npt.NDArray[np.int64]:
        """Triangles of the template, (F, 3)."""
        return self.arrays["faces"]

    @property
    def positions(self) -> Floats:
        """Registered templates, each in the coordinates of its specimen, (M, W, 3)."""
        return self.arrays["positions"]

    @property
    def mean(self) -> Floats:
        """Mean shape, (W, 3), centred at the origin."""
        return self.arrays["mean"]

    @property
    def directions(self) -> Floats:
        """Principal components, (C, W, 3): directions in which all vertices move together.

        They are orthonormal over the vertices of the registered template. Vertices of the file that
        were merged, as they are at one place, have equal rows, and those that no face uses that of
        the first used one: sums over all rows count these again.
        """
        return self.arrays["components"]

    @property
    def scores(self) -> Floats:
        """Coordinates of the specimens in the principal components, (M, C)."""
        return self.arrays["scores"]

    def shape_of(self, scores: npt.ArrayLike) -> Floats:
        """Return the shape of given scores, ``mean + np.tensordot(scores, directions, 1)``.

        Parameters
        ----------
        scores
            (C,) coordinates in the principal components, or (..., C).

        Returns
        -------
        (W, 3) or (..., W, 3). Of the scores of a specimen, its vertices, moved and rotated onto the
        mean, and scaled if :attr:`scale`.

        Raises
        ------
        ValueError
            There is not a score for each component; or as for :attr:`arrays`.

        Examples
        --------
        >>> aligned = registration.shape_of(registration.scores)  # all registered specimens
        """
        given = np.asarray(scores, dtype=np.float64)
        count = len(self.directions)
        if given.ndim == 0 or given.shape[-1] != count:
            raise ValueError(f"give {count} scores, one for each component, not {given.shape}")
        found: Floats = self.mean + np.tensordot(given, self.directions, 1)
        return found

    def save_meshes(self, folder: str | os.PathLike[str], names: Sequence[str] = ()) -> list[Path]:
        """Write a PLY file for each registered specimen, ``mean.ply``, and the components.

        ``components.npz`` has the arrays, ``scores.csv`` a row for each specimen: its name, its
        coordinates in the components, the confidence, whether it is in doubt, and the reasons for
        doubt. If it was not registered, all are empty but the reason.

        Parameters
        ----------
        folder
            Where the files are written; made if it is missing.
        names
            Names of the files of all specimens, without ending; by default those of the specimens.

        Returns
        -------
        The files.

        Raises
        ------
        OSError
            A file cannot be written.
        ValueError
            Two files have the same name, or `names` is not as long as :attr:`specimens`; or as for
            :attr:`arrays`.
        """
        named = list(names) or [Path(one.name or one.shape).stem for one in self.specimens]
        if len(named) != len(self.specimens):
            raise ValueError(
                f"{len(self.specimens)} specimens have as many names, not {len(named)}"
            )
        done = [name for name, one in zip(named, self.specimens, strict=True) if one.registered]
        meshes = [*zip(done, self.positions, strict=True), ("mean", self.mean)]
        paths = [Path(folder) / f"{name}.ply" for name, _ in meshes]
        if len(set(paths)) < len(paths):
            twice = next(path.stem for path in paths if paths.count(path) > 1)
            raise ValueError(f"two files would be called {twice!r}; give other names")
        Path(folder).mkdir(parents=True, exist_ok=True)
        for path, (_, positions) in zip(paths, meshes, strict=True):
            path.write_bytes(binary_ply(positions, self.faces))
        archive = Path(folder) / "components.npz"
        assert self._archive is not None
        archive.write_bytes(self._archive)
        table = Path(folder) / "scores.csv"
        with table.open("w", encoding="utf-8", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            numbers = range(1, len(self.components) + 1)
            scores = (f"pc{number}" for number in numbers)
            rows.writerow(("specimen", *scores, "confidence", "in_doubt", "reasons"))
            for name, one in zip(named, self.specimens, strict=True):
                scored = one.scores or [""] * len(self.components)
                rows.writerow((name, *scored, *_confidence(one)))
        return [*paths, archive, table]

    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        raise ValueError("a registration has no figure; job.picture() has one of the components")


def _confidence(one: Specimen) -> tuple[float | str, str, str]:
    """Confidence, whether the specimen is in doubt, as R and pandas read it, and the reasons."""
    if one.confidence is None:
        return "", "", f"not registered: {one.reason}"
    doubted = str(one.confidence.in_doubt).lower()
    return one.confidence.probability, doubted, "; ".join(one.confidence.reasons)


def _line(one: Specimen, name: str) -> str:
    if not one.registered:
        return f"{name}: not registered: {one.reason}"
    reflected = ", reflected" if one.reflected else ""
    distance = f"distance at most {one.max_distance:.2g}"
    return f"{name}: {distance}, {one.flipped} flipped triangles{reflected}, {one.confidence}"
