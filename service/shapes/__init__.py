"""Shapes: uploading, listing, fetching and deleting meshes."""

from service.shapes.files import get_geometry

__all__ = ["get_geometry"]
