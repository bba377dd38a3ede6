"""Choice among candidates of a part: registered in stages, each of which keeps the best."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import compress

from solver.arrays import IntArray
from solver.control import Control
from solver.registration.alignment import Alignment
from solver.registration.candidates import Points
from solver.registration.choice import SAME, distinct, meeting, missed
from solver.registration.partial.alignment import WEIGHTS, PartSamples, align_to_part, find_pairs
from solver.registration.partial.fit import PartFit, measure_part_fit, scale_of
from solver.registration.surface import Samples, SmoothSurface


@dataclass(frozen=True)
class PartStage:
    """A stage of the search.

    Parameters
    ----------
    whole_samples, part_samples
        Numbers of samples.
    sizes
        Numbers of eigenfunctions to go through.
    kept
        How many candidates are kept.
    same
        Mean distance in space over √area between the images of candidates that are the same.
    """

    whole_samples: int
    part_samples: int
    sizes: tuple[int, ...]
    kept: int
    same: float = SAME


@dataclass(frozen=True, eq=False)
class PartTask:
    """What is registered.

    Parameters
    ----------
    whole, part
        The surfaces.
    entire
        Whether every point of the part has a partner. Else the surfaces overlap, and neither is a
        part of the other.
    rescaled
        Whether the scale is searched for.
    landmarks
        Vertices of the whole and of the part that correspond.
    """

    whole: SmoothSurface
    part: SmoothSurface
    entire: bool
    rescaled: bool
    landmarks: Points

    def samples(self, stage: PartStage) -> tuple[Samples, PartSamples]:
        """Samples of a stage."""
        whole = self.whole.samples.first(stage.whole_samples)
        return whole, PartSamples.of((self.whole, self.part), stage.part_samples, self.entire)


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
    if task.rescaled:
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
