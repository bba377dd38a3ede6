"""Local structures: the descriptors f_X, sections 3.5 to 3.8."""

from dataclasses import dataclass

import numpy as np

from solver.errors import OptionError
from solver.structures.choice import Invariance, Parameter, Structure, parameter
from solver.structures.metrics import GREATEST

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


DESCRIPTORS: dict[str, type[DescriptorChoice]] = {
    kind.name: kind
    for kind in (NoDescriptor, HeatKernelSignature, ScaleInvariantHeatKernelSignature)
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
