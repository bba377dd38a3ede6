"""Task of a partial registration: two surfaces, and how their candidates are registered."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import ClassVar

from solver.arrays import FloatArray, IntArray
from solver.registration.alignment import Alignment
from solver.registration.candidates import NO_LANDMARKS, Points
from solver.registration.choice import Candidate, Stage, missed
from solver.registration.partial.alignment import PartSamples, align_to_part, find_pairs
from solver.registration.partial.fit import measure_part_fit, scale_of
from solver.registration.partial.partiality import Partiality
from solver.registration.surface import Samples, SmoothSurface, smooth_surface
from solver.shape import Shape

_COMPARED = 200
"""Samples of the part whose partners are compared."""

Start = tuple[Alignment, float]
"""Alignment that a candidate begins with, and √area of the whole in the part's unit."""


@dataclass(frozen=True, eq=False)
class PartTask:
    """What is registered.

    Parameters
    ----------
    shapes
        The whole and the part.
    partiality
        What they are to one another.
    scale
        √area of the whole over √area of the part; ``None`` if it is searched for.
    landmarks
        Vertices of the whole and of the part that correspond.
    """

    shapes: tuple[Shape, Shape]
    partiality: Partiality
    scale: float | None = None
    landmarks: Points = NO_LANDMARKS

    drops_missing: ClassVar[bool] = True

    @property
    def surfaces(self) -> tuple[SmoothSurface, SmoothSurface]:
        """Surfaces of the whole and of the part."""
        whole, part = self.shapes
        return smooth_surface(whole), smooth_surface(part)

    @property
    def whole(self) -> SmoothSurface:
        """Surface of the whole."""
        return self.surfaces[0]

    @property
    def part(self) -> SmoothSurface:
        """Surface of the part."""
        return self.surfaces[1]

    @property
    def positions(self) -> FloatArray:
        """(V, 3) vertices of the whole."""
        return self.whole.mesh.vertices

    def sampled(self, stage: Stage) -> tuple[Samples, PartSamples]:
        """Samples of a stage."""
        whole, part = (one.samples for one in self.surfaces)
        return whole.first(stage.source_samples), self.at(part.vertices[: stage.target_samples])

    def at(self, vertices: IntArray) -> PartSamples:
        """Return chosen vertices of the part as samples."""
        return PartSamples.at(self.surfaces, vertices, self.partiality.entire)

    def again(
        self, candidates: Iterable[Candidate], stage: Stage
    ) -> Callable[[tuple[Samples, PartSamples]], list[Start]]:
        """Return where candidates go on, in whatever stage."""
        starts = [(one.alignment, one.scale) for one in candidates]
        return lambda samples: starts

    def register(
        self, samples: tuple[Samples, PartSamples], start: Start, stage: Stage
    ) -> Candidate:
        """Register a candidate in one stage, whose samples are given, and measure its fit."""
        whole, part = samples
        alignment, scale = start
        alignment = align_to_part(whole, part, alignment, scale, stage.sizes, stage.weights)
        if self.scale is None:
            scale = scale_of(whole, part, alignment, scale)
        fit = measure_part_fit(whole, part, alignment, scale)
        pairs = find_pairs(whole, part, alignment, scale, stage.weights)
        images = whole.vertices[pairs.back[:_COMPARED]]
        away = missed(self.whole, self.part.mesh.vertices, alignment, self.landmarks)
        return Candidate(alignment, fit, images, missed=away / scale, scale=scale)
