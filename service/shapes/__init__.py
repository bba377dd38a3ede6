"""Shapes: uploading, listing, fetching and deleting meshes; checks of the shapes of a job."""

from service.shapes import endpoints, files
from service.shapes.lookup import PATH as SHAPES_PATH
from service.shapes.lookup import use_shapes
from service.shapes.requirements import (
    check_shapes,
    counted,
    descriptor_problems,
    few_vertices,
    refuse,
    repeated_shapes,
    shape_fields,
    simplified_too_far,
    vertices_out_of_range,
)

ROUTERS = (endpoints.router, files.router)

__all__ = [
    "ROUTERS",
    "SHAPES_PATH",
    "check_shapes",
    "counted",
    "descriptor_problems",
    "few_vertices",
    "refuse",
    "repeated_shapes",
    "shape_fields",
    "simplified_too_far",
    "use_shapes",
    "vertices_out_of_range",
]
