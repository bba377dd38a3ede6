"""Choices of structures, section 3 and Table 1: names and parameters, not computations.

A choice is a name and its parameters, a frozen value that can be compared, hashed and cached by.
``Shape`` computes what is chosen.
"""

from solver.shape.choices.choice import DEGREES, Degree, Structure, all_chosen
from solver.shape.choices.descriptors import (
    DESCRIPTORS,
    HEAT_TIMES,
    ConformalFactor,
    DescriptorChoice,
    Eigenfunctions,
    GaussianCurvature,
    GeodesicHistogram,
    HeatKernelSignature,
    NoDescriptor,
    Photometric,
    ScaleInvariantHeatKernelSignature,
    WaveKernelSignature,
    descriptor_choice,
)
from solver.shape.choices.metrics import (
    GREATEST,
    METRICS,
    Biharmonic,
    CommuteTime,
    Diffusion,
    Geodesic,
    MetricChoice,
    Varadhan,
    metric_choice,
)

__all__ = [
    "DEGREES",
    "DESCRIPTORS",
    "GREATEST",
    "HEAT_TIMES",
    "METRICS",
    "Biharmonic",
    "CommuteTime",
    "ConformalFactor",
    "Degree",
    "DescriptorChoice",
    "Diffusion",
    "Eigenfunctions",
    "GaussianCurvature",
    "Geodesic",
    "GeodesicHistogram",
    "HeatKernelSignature",
    "MetricChoice",
    "NoDescriptor",
    "Photometric",
    "ScaleInvariantHeatKernelSignature",
    "Structure",
    "Varadhan",
    "WaveKernelSignature",
    "all_chosen",
    "descriptor_choice",
    "metric_choice",
]
