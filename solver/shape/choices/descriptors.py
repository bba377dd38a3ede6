"""Local structures: the descriptors f_X, sections 3.5 to 3.8."""

from dataclasses import dataclass

import numpy as np

from solver.errors import OptionError
from solver.shape.choices.choice import Invariance, Parameter, Structure, parameter
from solver.shape.choices.metrics import GREATEST

HEAT_TIMES = tuple(np.geomspace(np.log(10.0) / (100.0 * np.pi), 1.0, 32).tolist())
"""Time scales of the heat kernel signature on a surface of unit area. They begin at 4 ln 10 / λ,
λ = 4π · 100 being the hundredth eigenvalue by Weyl's law: its term has decayed to 10⁻⁴ by then
(Sun, Ovsjanikov and Guibas, SGP 2009). At their end little but the constant is left."""


@dataclass(frozen=True)
class DescriptorChoice(Structure):
    """A descriptor f_X by its name, with the values of its parameters."""


@dataclass(frozen=True)
class NoDescriptor(DescriptorChoice):
    """No descriptor: the first-order term is left out."""

    name = "none"
    invariance = Invariance(bending="yes", topology="yes", scale="yes")


@dataclass(frozen=True)
class Photometric(DescriptorChoice):
    """Mean colour of the surface around a point, sections 3.8 and 6.3.

    Parameters
    ----------
    radius
        Of the geodesic disc that is averaged over; 0 for the point's own colour. ``None`` for
        0.03 times √area.
    """

    name = "photometric"
    invariance = Invariance(bending="yes", topology="yes", scale="yes")
    colored = True

    radius: float | None = parameter(Parameter(0.0, GREATEST, 0.03, "length"))


@dataclass(frozen=True)
class GeodesicHistogram(DescriptorChoice):
    """Local histogram of geodesic distances, section 3.5.

    Parameters
    ----------
    radius
        Of the geodesic disc; ``None`` for 0.3 times √area.
    bins
        Annuli into which it is divided.
    """

    name = "geodesic_histogram"
    invariance = Invariance(bending="yes", topology="no", scale="no")

    radius: float | None = parameter(Parameter(1.0 / GREATEST, GREATEST, 0.3, "length"))
    bins: int = parameter(Parameter(1, 64, 8))


@dataclass(frozen=True)
class GaussianCurvature(DescriptorChoice):
    """Gaussian curvature, averaged over a neighbourhood.

    Parameters
    ----------
    scale
        Root mean square distance over which is averaged; 0 for none, ``None`` for 0.1 times √area.
    """

    name = "gaussian_curvature"
    invariance = Invariance(bending="yes", topology="no", scale="no")

    scale: float | None = parameter(Parameter(0.0, GREATEST, 0.1, "length"))


@dataclass(frozen=True)
class ConformalFactor(DescriptorChoice):
    """Conformal factor of the map to even curvature (Ben-Chen and Gotsman, 3DOR 2008)."""

    name = "conformal_factor"
    invariance = Invariance(bending="yes", topology="no", scale="yes")


@dataclass(frozen=True)
class Eigenfunctions(DescriptorChoice):
    """Laplace-Beltrami eigenfunctions (Hu and Hua 2009; Dubrovina and Kimmel 2010).

    Parameters
    ----------
    count
        Eigenfunctions looked at, the constant one not among them.
    """

    name = "eigenfunctions"
    invariance = Invariance(bending="yes", topology="no", scale="yes")
    spectral = True

    count: int = parameter(Parameter(1, 100, 20))


@dataclass(frozen=True)
class HeatKernelSignature(DescriptorChoice):
    """Heat kernel signature, section 3.6.

    Parameters
    ----------
    times
        t_1, ..., t_n in the square of the shapes' unit of length; ``None`` for `HEAT_TIMES`
        times their area.
    """

    name = "hks"
    invariance = Invariance(bending="yes", topology="approx", scale="no")
    spectral = True

    times: tuple[float, ...] | None = parameter(
        Parameter(1.0 / GREATEST, GREATEST, HEAT_TIMES, "area", longest=128)
    )


@dataclass(frozen=True)
class ScaleInvariantHeatKernelSignature(DescriptorChoice):
    """Scale-invariant heat kernel signature, section 3.7.

    Parameters
    ----------
    frequencies
        How many of the lowest frequencies are kept.
    """

    name = "si_hks"
    invariance = Invariance(bending="yes", topology="approx", scale="yes")
    spectral = True

    frequencies: int = parameter(Parameter(1, 40, 6))


@dataclass(frozen=True)
class WaveKernelSignature(DescriptorChoice):
    """Wave kernel signature (Aubry, Schlickewei and Cremers, ICCV workshops 2011).

    Parameters
    ----------
    sigma
        Width σ of the filters, in logarithms of eigenvalues.
    """

    name = "wks"
    invariance = Invariance(bending="yes", topology="no", scale="yes")
    spectral = True

    sigma: float = parameter(Parameter(0.01, 10.0, 0.2))


DESCRIPTORS: dict[str, type[DescriptorChoice]] = {
    kind.name: kind
    for kind in (
        NoDescriptor,
        Photometric,
        GeodesicHistogram,
        GaussianCurvature,
        ConformalFactor,
        Eigenfunctions,
        HeatKernelSignature,
        ScaleInvariantHeatKernelSignature,
        WaveKernelSignature,
    )
}
"""The descriptors by name, "none" included."""


def descriptor_choice(given: DescriptorChoice | str, field: str = "descriptor") -> DescriptorChoice:
    """Return a choice, for a name the one with default parameters.

    Raises
    ------
    OptionError
        There is no such descriptor; the option is `field`.
    """
    if isinstance(given, DescriptorChoice) and given.name in DESCRIPTORS:
        return given
    if not isinstance(given, str) or given not in DESCRIPTORS:
        raise OptionError(field, f"{given!r} is none of {', '.join(DESCRIPTORS)}")
    return DESCRIPTORS[given]()
