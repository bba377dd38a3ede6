"""Addresses of blob stores: ``file:///DIRECTORY`` or ``s3://BUCKET/PREFIX``."""

from pathlib import Path
from typing import Annotated, TypeAlias
from urllib.parse import unquote, urlsplit

from pydantic import AfterValidator

from broker.blobs.blob_store import BlobStore
from broker.blobs.directory import DirectoryBlobs
from broker.blobs.left_to_sweep import LeftToSweep


def _blob_url(url: str) -> str:
    parts = urlsplit(url)
    directory = parts.scheme == "file" and not parts.netloc and parts.path.startswith("/")
    if not directory and not (parts.scheme == "s3" and parts.netloc):
        raise ValueError("give file:///DIRECTORY with an absolute path, or s3://BUCKET/PREFIX")
    return url


BlobUrl: TypeAlias = Annotated[str, AfterValidator(_blob_url)]
"""``file:///DIRECTORY`` or ``s3://BUCKET/PREFIX``."""


def open_blobs(url: BlobUrl, patience: float, forks: bool = False) -> BlobStore:
    """Return the blob store at an address; nothing is read or written yet.

    Parameters
    ----------
    url
        Its address.
    patience
        Seconds for which a request to object storage is repeated while the server is away.
    forks
        Whether this process forks others that open the store themselves. It then only deletes
        records where the blobs are in object storage.
    """
    parts = urlsplit(url)
    if parts.scheme == "file":
        return DirectoryBlobs(Path(unquote(parts.path)))
    # The import takes 45 ms, which only installations with object storage pay.
    from broker.blobs.object_storage import ObjectStorage

    # A process that forks imports it for all of its forks.
    return LeftToSweep() if forks else ObjectStorage(url, patience)
