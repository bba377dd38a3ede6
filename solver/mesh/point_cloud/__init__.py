"""Point clouds: surfaces whose vertices are the points."""

from solver.mesh.point_cloud.surface import surface_of_points

__all__ = ["surface_of_points"]
