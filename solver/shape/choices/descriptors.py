"""Local structures: the descriptors f_X, sections 3.5 to 3.8.

A descriptor is declared here, and nowhere else besides the numerics: ``make generate`` writes the
rest.
"""

from dataclasses import dataclass

import numpy as np

from solver.parameters import parameter
from solver.shape.choices.choice import Invariance, Structure, chosen
from solver.shape.choices.metrics import GREATEST, LEAST

HEAT_TIMES = tuple(np.geomspace(np.log(10.0) / (100.0 * np.pi), 1.0, 32).round(12).tolist())
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
    formula = "0"
    source = ""
    invariance = Invariance(bending="yes", topology="yes", scale="yes")


@dataclass(frozen=True)
class Photometric(DescriptorChoice):
    """Colour of the vertices, averaged over a geodesic disc; only for shapes that have colours."""

    name = "photometric"
    formula = "mean of (r, g, b) / √3 over {z : d(x, z) <= radius}"
    source = "3.8, 6.3"
    invariance = Invariance(bending="yes", topology="yes", scale="yes")
    remarks = (
        "With even illumination, and with radius 0 or unchanged parts of the disc's size, as the"
        " footnotes of Table 1 say."
    )
    colored = True

    radius: float | None = parameter(
        0.03,
        "Radius of the disc; 0 for the vertex alone.",
        least=0.0,
        most=GREATEST,
        unit="length",
    )


@dataclass(frozen=True)
class GeodesicHistogram(DescriptorChoice):
    """Areas of geodesic annuli around a point, relative to those in the plane."""

    name = "geodesic_histogram"
    formula = "area {z : (j - 1) r / B <= d(x, z) < j r / B}, divided by that in the plane"
    source = "3.5; Raviv, Bronstein, Bronstein, Kimmel: Symmetries of non-rigid shapes, NORDIA 2007"
    invariance = Invariance(bending="yes", topology="no", scale="no")
    remarks = "Not changed at points farther from a change of topology than the radius."

    radius: float | None = parameter(
        0.3, "Radius r of the disc.", least=LEAST, most=GREATEST, unit="length"
    )
    bins: int = parameter(8, "Number B of annuli.", least=1, most=64)


@dataclass(frozen=True)
class GaussianCurvature(DescriptorChoice):
    """Gaussian curvature, averaged over a neighbourhood."""

    name = "gaussian_curvature"
    formula = "angle defect / area, both spread by a heat flow of time scale² / 4"
    source = "Table 1; Meyer, Desbrun, Schröder, Barr 2003"
    value_unit = "1/length²"
    invariance = Invariance(bending="yes", topology="no", scale="no")
    remarks = "Hardly changed at points farther from a change of topology than the scale."

    scale: float | None = parameter(
        0.1,
        "Root mean square radius of the neighbourhood; 0 for no averaging.",
        least=0.0,
        most=GREATEST,
        unit="length",
    )


@dataclass(frozen=True)
class ConformalFactor(DescriptorChoice):
    """Logarithm of the factor by which lengths have to change for constant curvature."""

    name = "conformal_factor"
    formula = "Δφ = K_T - K, mean of φ 0"
    source = "Table 1; Ben-Chen, Gotsman: Characterizing shape using conformal factors, 3DOR 2008"
    invariance = Invariance(bending="yes", topology="no", scale="yes")
    remarks = (
        "Table 1 says that it changes with scale: it does if the constant that the equation leaves"
        " open is fixed by a size; here it is fixed by the mean."
    )


@dataclass(frozen=True)
class Eigenfunctions(DescriptorChoice):
    """Values of the Laplace-Beltrami eigenfunctions of lowest frequency.

    Signs are chosen where the distributions of values determine them, and magnitudes compared
    elsewhere; eigenfunctions whose order could differ are compared as groups, by their norm. For
    dissimilarities, where every shape is described by itself, only magnitudes are compared.
    """

    name = "eigenfunctions"
    formula = "√area (φ_1(x), ..., φ_n(x))"
    source = "3.5; Hu, Hua 2009; Dubrovina, Kimmel 2010"
    invariance = Invariance(bending="yes", topology="no", scale="yes")
    spectral = True

    count: int = parameter(
        20, "Number of eigenfunctions, the constant one not counted.", least=1, most=100
    )


@dataclass(frozen=True)
class HeatKernelSignature(DescriptorChoice):
    """Heat left at a point after several times, relative to the mean of all points."""

    name = "hks"
    formula = "h_t(x, x) = Σ exp(-λ_i t) φ_i(x)², times area / Σ exp(-λ_i t)"
    source = "3.6"
    invariance = Invariance(bending="yes", topology="approx", scale="no")
    spectral = True

    times: tuple[float, ...] | None = parameter(
        HEAT_TIMES,
        "Times t_1, ..., t_n.",
        least=LEAST,
        most=GREATEST,
        unit="area",
        longest=128,
    )


@dataclass(frozen=True)
class ScaleInvariantHeatKernelSignature(DescriptorChoice):
    """Magnitudes of the Fourier transform of d/dτ log h over τ = log₂ t."""

    name = "si_hks"
    formula = "|F(d/dτ log h_t(x, x))|, t = 2^τ"
    source = "3.7"
    invariance = Invariance(bending="yes", topology="approx", scale="yes")
    spectral = True

    frequencies: int = parameter(6, "Number of lowest frequencies kept.", least=1, most=40)


@dataclass(frozen=True)
class WaveKernelSignature(DescriptorChoice):
    """Probability of finding quantum particles of several energies at a point, over its mean.

    Energies are evenly spaced over the logarithms of the eigenvalues that a surface of this area
    has by Weyl's law.
    """

    name = "wks"
    formula = "Σ φ_i(x)² exp(-(e - log λ_i)² / 2σ²), over its mean"
    source = "Aubry, Schlickewei, Cremers: The wave kernel signature, ICCV workshops 2011"
    invariance = Invariance(bending="yes", topology="no", scale="yes")
    remarks = "Not in Table 1: measured."
    spectral = True

    sigma: float = parameter(
        0.2, "Width σ of the filters, in logarithms of eigenvalues.", least=0.01, most=10.0
    )


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


def descriptor_choice(given: DescriptorChoice | str) -> DescriptorChoice:
    """Return a descriptor; for a name, the one with default parameters: see :func:`.chosen`."""
    return chosen(given, DESCRIPTORS, "descriptor")
