"""The descriptors that can be chosen, sections 3.5 to 3.8 of the paper."""

import math
from typing import Annotated, Final, Literal, TypeAlias, get_args

from pydantic import ConfigDict, Field, Tag
from pydantic.json_schema import SkipJsonSchema
from typing_extensions import TypeAliasType

from broker.contracts.structures import (
    GREATEST,
    LEVELS,
    NAME,
    ONE,
    SEVERAL,
    UNKNOWN,
    About,
    Choice,
    Suited,
    by_name,
    one_or_several,
)

DescriptorName: TypeAlias = Literal[
    "none",
    "photometric",
    "geodesic_histogram",
    "gaussian_curvature",
    "conformal_factor",
    "eigenfunctions",
    "hks",
    "si_hks",
    "wks",
]

_SHORTEST: Final = math.log(10.0) / (100.0 * math.pi)
_HEAT_TIMES: Final = tuple(_SHORTEST ** (1.0 - i / 31.0) for i in range(32))


class NoDescriptor(Choice):
    """No descriptor: the first-order term is left out."""

    about = About("0", "", "1", ("yes", "yes", "yes"))

    name: Literal["none"]


class Photometric(Choice):
    """Colour of the vertices, averaged over a geodesic disc; it takes shapes that have colours."""

    about = About(
        "mean of (r, g, b) / √3 over {z : d(x, z) <= radius}",
        "3.8, 6.3",
        "1",
        ("yes", "yes", "yes"),
        colored=True,
        remarks="With even illumination, and radius 0 or parts of the disc's size left as they"
        " are, as the footnotes of Table 1 say.",
    )

    name: Literal["photometric"]
    radius: Annotated[float | None, Suited(0.03, "length")] = Field(
        default=None,
        ge=0.0,
        le=GREATEST,
        description="Radius of the disc, in the shapes' unit of length; 0 for the vertex alone,"
        " null for 0.03 of √area.",
    )


class GeodesicHistogram(Choice):
    """Areas of geodesic annuli round a point, relative to those in the plane."""

    about = About(
        "area {z : (j - 1) r / B <= d(x, z) < j r / B}, divided by that in the plane",
        "3.5; Raviv, Bronstein, Bronstein, Kimmel: Symmetries of non-rigid shapes, NORDIA 2007",
        "1",
        ("yes", "no", "no"),
        remarks="Points farther from a change of topology than the radius do not notice it.",
    )

    name: Literal["geodesic_histogram"]
    radius: Annotated[float | None, Suited(0.3, "length")] = Field(
        default=None,
        ge=1.0 / GREATEST,
        le=GREATEST,
        description="Radius r of the disc, in the shapes' unit of length; null for 0.3 of √area.",
    )
    bins: int = Field(default=8, ge=1, le=64, description="Number B of annuli.")


class GaussianCurvature(Choice):
    """Gaussian curvature, averaged over a neighbourhood."""

    about = About(
        "angle defect / area, both spread by a heat flow of time scale² / 4",
        "Table 1; Meyer, Desbrun, Schröder, Barr 2003",
        "1/length²",
        ("yes", "no", "no"),
        remarks="Points farther from a change of topology than the scale hardly notice it.",
    )

    name: Literal["gaussian_curvature"]
    scale: Annotated[float | None, Suited(0.1, "length")] = Field(
        default=None,
        ge=0.0,
        le=GREATEST,
        description="Root mean square distance over which is averaged, in the shapes' unit of"
        " length; 0 for none, null for 0.1 of √area.",
    )


class ConformalFactor(Choice):
    """Logarithm of the factor by which lengths have to change for the curvature to be even."""

    about = About(
        "Δφ = K_T - K, mean of φ 0",
        "Table 1; Ben-Chen, Gotsman: Characterizing shape using conformal factors, 3DOR 2008",
        "1",
        ("yes", "no", "yes"),
        remarks="Table 1 says that it changes with scale: it does if the constant that the"
        " equation leaves open is fixed by a size, and here it is fixed by the mean.",
    )

    name: Literal["conformal_factor"]


class Eigenfunctions(Choice):
    """Values of the Laplace-Beltrami eigenfunctions of lowest frequency.

    Signs are chosen where the distributions of values tell them, and magnitudes compared where
    they do not; eigenfunctions whose order could differ are compared as groups, by their norm. In
    dissimilarities, where a shape is described by itself, magnitudes of the first ones together.
    """

    about = About(
        "√area (φ_1(x), ..., φ_n(x))",
        "3.5; Hu, Hua 2009; Dubrovina, Kimmel 2010",
        "1",
        ("yes", "no", "yes"),
        spectral=True,
    )

    name: Literal["eigenfunctions"]
    count: int = Field(
        default=20, ge=1, le=100, description="Eigenfunctions looked at, without the constant one."
    )


class HeatKernelSignature(Choice):
    """How much heat is left at a point after several times, relative to the mean of all points."""

    about = About(
        "h_t(x, x) = Σ exp(-λ_i t) φ_i(x)², times area / Σ exp(-λ_i t)",
        "3.6",
        "1",
        ("yes", "approx", "no"),
        spectral=True,
    )

    name: Literal["hks"]
    times: Annotated[
        tuple[Annotated[float, Field(ge=1.0 / GREATEST, le=GREATEST)], ...] | None,
        Suited(_HEAT_TIMES, "area"),
    ] = Field(
        default=None,
        min_length=1,
        max_length=128,
        strict=False,
        description="Times t, in the square of the shapes' unit of length. Null for 32 from 0.0073"
        " to 1 of their area, each greater than the last by the same factor.",
    )


class ScaleInvariantHeatKernelSignature(Choice):
    """Magnitudes of the Fourier transform of d/dτ log h over τ = log₂ t."""

    about = About(
        "|F(d/dτ log h_t(x, x))|, t = 2^τ", "3.7", "1", ("yes", "approx", "yes"), spectral=True
    )

    name: Literal["si_hks"]
    frequencies: int = Field(
        default=6, ge=1, le=40, description="How many of the lowest frequencies are kept."
    )


class WaveKernelSignature(Choice):
    """How likely quantum particles of several energies are found at a point, relative to the mean.

    Energies are evenly spaced over the logarithms of the eigenvalues that a surface of this area
    has by Weyl's law.
    """

    about = About(
        "Σ φ_i(x)² exp(-(e - log λ_i)² / 2σ²), over its mean",
        "Aubry, Schlickewei, Cremers: The wave kernel signature, ICCV workshops 2011",
        "1",
        ("yes", "no", "yes"),
        spectral=True,
        remarks="Not in Table 1: measured.",
    )

    name: Literal["wks"]
    sigma: float = Field(
        default=0.2, ge=0.01, le=10.0, description="Width of the filters, in logarithms."
    )


class UnknownDescriptor(Choice):
    """What an object without the name of a descriptor is refused by."""

    model_config = ConfigDict(extra="ignore")

    name: DescriptorName


DESCRIPTORS: Final[dict[str, type[Choice]]] = {
    "none": NoDescriptor,
    "photometric": Photometric,
    "geodesic_histogram": GeodesicHistogram,
    "gaussian_curvature": GaussianCurvature,
    "conformal_factor": ConformalFactor,
    "eigenfunctions": Eigenfunctions,
    "hks": HeatKernelSignature,
    "si_hks": ScaleInvariantHeatKernelSignature,
    "wks": WaveKernelSignature,
}

Descriptor = TypeAliasType(
    "Descriptor",
    Annotated[
        Annotated[DescriptorName, Tag(NAME)]
        | Annotated[NoDescriptor, Tag("choice[none]")]
        | Annotated[Photometric, Tag("choice[photometric]")]
        | Annotated[GeodesicHistogram, Tag("choice[geodesic_histogram]")]
        | Annotated[GaussianCurvature, Tag("choice[gaussian_curvature]")]
        | Annotated[ConformalFactor, Tag("choice[conformal_factor]")]
        | Annotated[Eigenfunctions, Tag("choice[eigenfunctions]")]
        | Annotated[HeatKernelSignature, Tag("choice[hks]")]
        | Annotated[ScaleInvariantHeatKernelSignature, Tag("choice[si_hks]")]
        | Annotated[WaveKernelSignature, Tag("choice[wks]")]
        | SkipJsonSchema[Annotated[UnknownDescriptor, Tag(UNKNOWN)]],
        by_name(get_args(DescriptorName)),
    ],
)
"""A descriptor: its name, or that and its parameters."""

DescriptorByLevel: TypeAlias = Annotated[
    Annotated[Descriptor, Tag(ONE)] | Annotated[tuple[Descriptor, ...], LEVELS, Tag(SEVERAL)],
    one_or_several(),
]
"""A descriptor for all levels, or one for each."""


def descriptor_choice(given: Choice | str) -> Choice:
    """Return a descriptor with its parameters, for a name those by default."""
    return DESCRIPTORS[given](name=given) if isinstance(given, str) else given


def descriptor_choices(given: DescriptorByLevel) -> tuple[Choice, ...]:
    """Return descriptors with their parameters, of one for all levels or of one for each."""
    return tuple(map(descriptor_choice, given if isinstance(given, tuple) else (given,)))
