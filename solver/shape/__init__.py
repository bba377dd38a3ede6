"""Shapes with their structures, section 2 and 3: metrics, descriptors and samplings."""

from solver.shape.metrics import (
    BiharmonicMetric,
    CommuteTimeMetric,
    DiffusionMetric,
    EmbeddedMetric,
    GeodesicMetric,
    Metric,
)
from solver.shape.sampling import euclidean_farthest_points, farthest_first, farthest_point_sampling
from solver.shape.shape import WITHOUT_COLORS, Shape
from solver.shape.signed_volumes import signed_volumes
from solver.shape.varadhan import varadhan_distances

__all__ = [
    "WITHOUT_COLORS",
    "BiharmonicMetric",
    "CommuteTimeMetric",
    "DiffusionMetric",
    "EmbeddedMetric",
    "GeodesicMetric",
    "Metric",
    "Shape",
    "euclidean_farthest_points",
    "farthest_first",
    "farthest_point_sampling",
    "signed_volumes",
    "varadhan_distances",
]
