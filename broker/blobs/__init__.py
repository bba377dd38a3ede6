"""The blob store: large bytes under paths, in a directory or in S3-compatible object storage."""

from broker.blobs.addresses import BlobUrl, open_blobs
from broker.blobs.blob_store import BlobEntry, BlobStore
from broker.blobs.errors import (
    BlobError,
    BlobLost,
    BlobsAway,
    BlobsFull,
    NotMigrated,
    no_space_left,
)

__all__ = [
    "BlobEntry",
    "BlobError",
    "BlobLost",
    "BlobStore",
    "BlobUrl",
    "BlobsAway",
    "BlobsFull",
    "NotMigrated",
    "no_space_left",
    "open_blobs",
]
