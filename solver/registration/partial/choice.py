"""Choice among candidates of a part: registered in stages, each of which keeps the best."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import compress

from solver.arrays import IntArray
from solver.control import Control
from solver.registration.alignment import Alignment
from solver.registration.candidates import NO_LANDMARKS, Points
from solver.registration.choice import distinct, meeting, missed
from solver.registration.partial.alignment import WEIGHTS, PartSamples, align_to_part, find_pairs
from solver.registration.partial.fit import PartFit, measure_part_fit, scale_of
from solver.registration.partial.partiality import Partiality, PartStage
from solver.registration.surface import Samples, SmoothSurface, smooth_surface
from solver.shape import Shape


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

    def samples(self, stage: PartStage) -> tuple[Samples, PartSamples]:
        """Samples of a stage."""
        whole, part = (one.samples for one in self.surfaces)
        return whole.first(stage.whole_samples), self.at(part.vertices[: stage.part_samples])

    def at(self, vertices: IntArray) -> PartSamples:
        """Return chosen vertices of the part as samples."""
        return PartSamples.at(self.surfaces, vertices, self.partiality.entire)


Start = tuple[Alignment, float]
"""Alignment that a candidate begins with, and √area of the whole in the part's unit."""


@dataclass(frozen=True, eq=False)
class PartCandidate:
    """A registered candidate.

    Parameters
    ----------
    alignment
        Of the whole to the part.
    scale
        √area of the whole in the part's unit.
    fit
        How well it fits.
    partners
        (M,) samples of the whole of the samples of the part.
    """

    alignment: Alignment
    scale: float
    fit: PartFit
    partners: IntArray

    @property
    def start(self) -> Start:
        """Where the next stage begins."""
        return self.alignment, self.scale


def choose_parts(
    task: PartTask,
    populations: Sequence[Sequence[Start]],
    stages: Sequence[PartStage],
    control: Control,
) -> list[list[PartCandidate]]:
    """Register populations of candidates in stages.

    They do not compete with one another.

    Parameters
    ----------
    task
        The surfaces.
    populations
        Where the candidates of each begin.
    stages
        That they go through.
    control
        May cancel; past its deadline, fewer are tried, at least one of each in each stage.

    Returns
    -------
    Of each, the candidates of the last stage that differ and meet the landmarks, the best first.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    prepared = [(stage, task.samples(stage)) for stage in stages]
    chosen = []
    for population in populations:
        starts, found = population, list[PartCandidate]()
        for stage, samples in prepared:
            registered = [
                register_part_candidate(task, samples, start, stage.sizes)
                for start in control.in_time(starts, least=1)
            ]
            found = ranked_parts(task, registered, stage)
            starts = [one.start for one in found]
        chosen.append(found)
    return chosen


def register_part_candidate(
    task: PartTask, samples: tuple[Samples, PartSamples], start: Start, sizes: Iterable[int]
) -> PartCandidate:
    """Register a candidate in one stage, whose samples are given, and measure its fit."""
    whole, part = samples
    alignment, scale = start
    alignment = align_to_part(whole, part, alignment, scale, sizes)
    if task.scale is None:
        scale = scale_of(whole, part, alignment, scale)
    fit = measure_part_fit(whole, part, alignment, scale)
    pairs = find_pairs(whole, part, alignment, scale, WEIGHTS)
    return PartCandidate(alignment, scale, fit, pairs.back)


_PARTNERS = 200
"""Samples of the part whose partners are compared."""


def ranked_parts(
    task: PartTask, found: Sequence[PartCandidate], stage: PartStage
) -> list[PartCandidate]:
    """Candidates that differ, the best first, of those that meet the landmarks.

    Parameters
    ----------
    task
        The surfaces.
    found
        Candidates at the same samples.
    stage
        How many are kept, and what is the same.
    """
    positions = task.whole.samples.positions
    order = sorted(_met(task, found), key=lambda one: one.fit.score)
    partners = (positions[one.partners[:_PARTNERS]] for one in order)
    return [order[row] for row in distinct(partners, stage.kept, stage.same)]


def _met(task: PartTask, found: Sequence[PartCandidate]) -> list[PartCandidate]:
    """Candidates that meet the landmarks as well as any, or nearly so."""
    positions = task.part.mesh.vertices
    away = [
        missed(task.whole, positions, one.alignment, task.landmarks) / one.scale for one in found
    ]
    return list(compress(found, meeting(away)))
