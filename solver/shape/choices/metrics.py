"""Global structures: the metrics d_X, sections 3.2 to 3.4."""

from dataclasses import dataclass

from solver.errors import OptionError
from solver.shape.choices.choice import Invariance, Parameter, Structure, parameter

DIFFUSION_TIME = 0.01
"""Default t of (3) on a surface of unit area.

Heat has spread over a distance of 2√t, a fifth of √area: past the size of fingers and holes, so
that gluing or cutting there changes little, and within that of limbs, so that points on them are
still told apart. The smallest of 100 terms has decayed to exp(-2 · 4π · 100 · t) ≈ 10⁻¹¹, by
Weyl's law: what the spectrum leaves out does not count.
"""

VARADHAN_TIME = 0.05
"""Time t of Varadhan's formula on a surface of unit area.

The less, the closer to geodesic distances, as long as h_t is known: of points at a distance d it is
exp(-d²/4t) times what it is at either, 10⁻⁹ at d = 2, which a spectrum still tells.
"""

GREATEST = 1e30
"""Bound of lengths and areas, and of their inverses."""


@dataclass(frozen=True)
class MetricChoice(Structure):
    """A metric d_X by its name, with the values of its parameters."""


@dataclass(frozen=True)
class Geodesic(MetricChoice):
    """Length of the shortest path on the surface, section 3.2."""

    name = "geodesic"
    invariance = Invariance(bending="yes", topology="no", scale="no")


@dataclass(frozen=True)
class Diffusion(MetricChoice):
    """Diffusion metric d_{X,t}, equation (3).

    Parameters
    ----------
    time
        t, in the square of the shapes' unit of length; ``None`` for `DIFFUSION_TIME` of their
        area.
    """

    name = "diffusion"
    invariance = Invariance(bending="yes", topology="approx", scale="no")
    spectral = True

    time: float | None = parameter(Parameter(1.0 / GREATEST, GREATEST, DIFFUSION_TIME, "area"))


@dataclass(frozen=True)
class CommuteTime(MetricChoice):
    """Commute-time metric δ_X, equation (4)."""

    name = "commute_time"
    invariance = Invariance(bending="yes", topology="approx", scale="yes")
    spectral = True


@dataclass(frozen=True)
class Biharmonic(MetricChoice):
    """Biharmonic metric (Lipman, Rustamov and Funkhouser, ACM TOG 29(3), 2010)."""

    name = "biharmonic"
    invariance = Invariance(bending="yes", topology="no", scale="no")
    spectral = True


@dataclass(frozen=True)
class Varadhan(MetricChoice):
    """Geodesic distance as heat tells it: see :func:`solver.shape.metrics.varadhan_distances`.

    No metric in the strict sense, and none to be asked for: it stands in for the geodesic one where
    only a spectrum is known.

    Parameters
    ----------
    time
        t, in the square of the shapes' unit of length; ``None`` for `VARADHAN_TIME` of their area.
    """

    name = "varadhan"
    invariance = Invariance(bending="yes", topology="approx", scale="no")
    spectral = True

    time: float | None = parameter(Parameter(1.0 / GREATEST, GREATEST, VARADHAN_TIME, "area"))


METRICS: dict[str, type[MetricChoice]] = {
    kind.name: kind for kind in (Geodesic, Diffusion, CommuteTime, Biharmonic)
}
"""The metrics by name, of those that can be asked for."""


def metric_choice(given: MetricChoice | str, field: str = "metric") -> MetricChoice:
    """Return a choice, for a name the one with default parameters.

    Raises
    ------
    OptionError
        There is no such metric; the option is `field`.
    """
    if isinstance(given, MetricChoice) and given.name in METRICS:
        return given
    if not isinstance(given, str) or given not in METRICS:
        raise OptionError(field, f"{given!r} is none of {', '.join(METRICS)}")
    return METRICS[given]()
