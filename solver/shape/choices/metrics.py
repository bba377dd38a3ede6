"""Global structures: the metrics d_X, sections 3.2 to 3.4.

A metric is declared here, and nowhere else besides the numerics: ``make generate`` writes the rest.
"""

from dataclasses import dataclass

from solver.parameters import parameter
from solver.shape.choices.choice import Invariance, Structure, chosen

DIFFUSION_TIME = 0.01
"""Default t of (3) on a surface of unit area.

Heat has spread over a distance of 2√t, a fifth of √area: past the size of fingers and holes, so
that gluing or cutting there changes little, and within that of limbs, so that points on them remain
distinct. The smallest of 100 terms has decayed to exp(-2 · 4π · 100 · t) ≈ 10⁻¹¹, by Weyl's law, so
that truncation of the spectrum is negligible.
"""

VARADHAN_TIME = 0.05
"""Time t of Varadhan's formula on a surface of unit area.

The less, the closer to geodesic distances, as long as h_t is known: for points at a distance d it
is exp(-d²/4t) times its value at either, 10⁻⁹ at d = 2, which a spectrum still resolves.
"""

GREATEST, LEAST = 1e30, 1e-30
"""Bounds of lengths and areas."""


@dataclass(frozen=True)
class MetricChoice(Structure):
    """A metric d_X by its name, with the values of its parameters."""


@dataclass(frozen=True)
class Geodesic(MetricChoice):
    """Length of the shortest path on the surface."""

    name = "geodesic"
    formula = "min ℓ(γ) over paths γ from x to y"
    source = "3.2"
    value_unit = "length"
    invariance = Invariance(bending="yes", topology="no", scale="no")


@dataclass(frozen=True)
class Diffusion(MetricChoice):
    """Difference of the heat that spreads from two points in time t: an average over all paths."""

    name = "diffusion"
    formula = "d² = Σ exp(-2 λ_i t) (φ_i(x) - φ_i(y))²"
    source = "3.3, (3)"
    value_unit = "1/length"
    invariance = Invariance(bending="yes", topology="approx", scale="no")
    spectral = True

    time: float | None = parameter(
        DIFFUSION_TIME,
        "Time t: heat spreads as far as 2√t.",
        least=LEAST,
        most=GREATEST,
        unit="area",
    )


@dataclass(frozen=True)
class CommuteTime(MetricChoice):
    """Square root of the expected time of a random walk from one point to another and back."""

    name = "commute_time"
    formula = "δ² = Σ (φ_i(x) - φ_i(y))² / λ_i"
    source = "3.4, (4)"
    invariance = Invariance(bending="yes", topology="approx", scale="yes")
    spectral = True


@dataclass(frozen=True)
class Biharmonic(MetricChoice):
    """Spectral distance like the geodesic one nearby, and dependent on the whole shape far away."""

    name = "biharmonic"
    formula = "d² = Σ (φ_i(x) - φ_i(y))² / λ_i²"
    source = "Lipman, Rustamov, Funkhouser: Biharmonic distance, ACM TOG 29(3), 2010"
    value_unit = "length"
    invariance = Invariance(bending="yes", topology="no", scale="no")
    remarks = "Not in Table 1: measured."
    spectral = True


@dataclass(frozen=True)
class Varadhan(MetricChoice):
    """Varadhan approximation of geodesic distance from the heat kernel.

    See :func:`solver.shape.varadhan_distances`. It is not a metric in the strict sense and
    cannot be chosen: it replaces the geodesic one where only a spectrum is known.
    """

    name = "varadhan"
    invariance = Invariance(bending="yes", topology="approx", scale="no")
    spectral = True

    time: float | None = parameter(
        VARADHAN_TIME, "Time t.", least=LEAST, most=GREATEST, unit="area"
    )


METRICS: dict[str, type[MetricChoice]] = {
    kind.name: kind for kind in (Geodesic, Diffusion, CommuteTime, Biharmonic)
}
"""The metrics that can be chosen, by name."""


def metric_choice(given: MetricChoice | str) -> MetricChoice:
    """Return a metric; for a name, the one with default parameters: see :func:`.chosen`."""
    return chosen(given, METRICS, "metric")
