from collections.abc import Iterator
from pathlib import Path

import isomatch
import pytest

from tests.client.shapes import write_blobs


@pytest.fixture(scope="session")
def blobs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Paths of ``a.off`` and ``b.obj``."""
    return write_blobs(tmp_path_factory.mktemp("blobs"))


@pytest.fixture
def client(url: str) -> Iterator[isomatch.Client]:
    with isomatch.Client(url) as client:
        yield client


@pytest.fixture
def pair(
    client: isomatch.Client, blobs: tuple[Path, Path]
) -> tuple[isomatch.Shape, isomatch.Shape]:
    return client.upload(blobs[0]), client.upload(blobs[1])
