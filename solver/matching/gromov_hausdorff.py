"""Gromov-Hausdorff distance of the samples of two shapes (section 2)."""

from solver.control import Control
from solver.labelling import LINF, greatest_distortions
from solver.matching.level import Level
from solver.matching.options import SAMPLES, MatchOptions
from solver.matching.result import GromovHausdorff
from solver.optimisation.exact import gromov_hausdorff_distance
from solver.shape import Shape

UNPROVEN_DISTANCE = "the Gromov-Hausdorff distance of the samples could not be proven in time"
"""Warning of a distance that is only bounded."""

_STAGE = "gromov-hausdorff distance"


def gromov_hausdorff(
    source: Shape, target: Shape, level: Level, options: MatchOptions, control: Control
) -> GromovHausdorff | None:
    """Compute or bound the Gromov-Hausdorff distance of as many samples of either shape.

    Parameters
    ----------
    source, target
        The shapes X and Y.
    level
        The one level of a match with objective "linf". Of its target samples, which are more, the
        first ones are taken, so that the distance is symmetric.
    options
        Of the match.
    control
        Reports progress and cancels. Past its deadline, the bounds known by then are returned.

    Returns
    -------
    GromovHausdorff
        ``None`` if it is not asked for, or the objective is another.

    Raises
    ------
    Cancelled
        Through `control`.
    """
    if options.proof != SAMPLES or options.objective != LINF:
        return None
    n = len(level.source.vertices)
    d_source, d_target = level.source.distances, level.target.distances[:n, :n]
    with (clock := control.timed()).stage(_STAGE), control.stage(_STAGE, 0.0):
        found = gromov_hausdorff_distance(
            d_source, d_target, seconds=options.proof_work, control=control
        )
    x, y = found.answer.T
    sampling = options.metric_at(0)
    return GromovHausdorff(
        points=n,
        source=source.mesh.vertex_ids[level.source.vertices[x]],
        target=target.mesh.vertex_ids[level.target.vertices[y]],
        costs=greatest_distortions(d_source[x][:, x], d_target[y][:, y]),
        value=0.5 * found.value,
        lower_bound=0.5 * found.lower_bound,
        sampling_error=sum(float(one.sampling(sampling, n).radii[-1]) for one in (source, target)),
        seconds=clock.timings[_STAGE],
    )
