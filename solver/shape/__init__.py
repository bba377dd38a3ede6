"""Shapes with their structures, section 2 and 3: metrics, descriptors and samplings."""

from solver.shape.metrics import (
    BiharmonicMetric,
    CommuteTimeMetric,
    DiffusionMetric,
    EmbeddedMetric,
    GeodesicMetric,
    Metric,
)
from solver.shape.sampling import farthest_first, farthest_point_sampling, spread_in_space
from solver.shape.shape import WITHOUT_COLORS, Shape
from solver.shape.varadhan import heat_images, lengths_by_heat, varadhan_distances

__all__ = [
    "WITHOUT_COLORS",
    "BiharmonicMetric",
    "CommuteTimeMetric",
    "DiffusionMetric",
    "EmbeddedMetric",
    "GeodesicMetric",
    "Metric",
    "Shape",
    "farthest_first",
    "farthest_point_sampling",
    "heat_images",
    "lengths_by_heat",
    "spread_in_space",
    "varadhan_distances",
]
