"""Blob stores of tests: directories."""

from pathlib import Path


def blob_url(folder: Path) -> str:
    """Address of the blob store in a folder of a test."""
    return (folder / "blobs").as_uri()
