"""Digests of content, which name uploads."""

import hashlib
from io import BufferedIOBase
from typing import BinaryIO, cast


def sha256_of(content: bytes | BinaryIO) -> str:
    """Return the SHA-256 of bytes or of a whole file, hexadecimal; a file is left at its start."""
    if isinstance(content, bytes):
        return hashlib.sha256(content).hexdigest()
    content.seek(0)
    digest = hashlib.file_digest(cast(BufferedIOBase, content), "sha256").hexdigest()
    content.seek(0)
    return digest
