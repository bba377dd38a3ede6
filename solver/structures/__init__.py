"""The structures a shape can be endowed with, section 3 and Table 1: choices, not computations.

A choice is a name and its parameters, a frozen value that can be compared, hashed and cached by.
``Shape`` computes what is chosen.
"""

from solver.structures.choice import DEGREES, Degree, Invariance, Parameter, Structure
from solver.structures.descriptors import (
    DESCRIPTORS,
    DescriptorChoice,
    HeatKernelSignature,
    NoDescriptor,
    ScaleInvariantHeatKernelSignature,
    descriptor_choice,
)
from solver.structures.metrics import (
    METRICS,
    Biharmonic,
    CommuteTime,
    Diffusion,
    Geodesic,
    MetricChoice,
    metric_choice,
)

__all__ = [
    "DEGREES",
    "DESCRIPTORS",
    "METRICS",
    "Biharmonic",
    "CommuteTime",
    "Degree",
    "DescriptorChoice",
    "Diffusion",
    "Geodesic",
    "HeatKernelSignature",
    "Invariance",
    "MetricChoice",
    "NoDescriptor",
    "Parameter",
    "ScaleInvariantHeatKernelSignature",
    "Structure",
    "descriptor_choice",
    "metric_choice",
]
