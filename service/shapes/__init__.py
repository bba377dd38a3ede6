"""Shapes: uploading, listing, fetching and deleting meshes."""
