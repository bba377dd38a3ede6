"""A service that takes small files only and lets nobody wait for their validation."""

from collections.abc import Iterator
from pathlib import Path

import isomatch
import numpy as np
import pytest

from demo.stack import running_stack
from tests.client.shapes import blob_meshes

LIMIT = 30_000
SETTINGS = {
    "ISOMATCH_VALIDATION_WAIT": "0",
    "ISOMATCH_MAX_UPLOAD_BYTES": str(LIMIT),
    "ISOMATCH_WORKERS": "1",
}


@pytest.fixture(scope="module")
def client() -> Iterator[isomatch.Client]:
    with running_stack(SETTINGS) as stack, isomatch.Client(stack.url) as client:
        yield client


def test_an_upload_waits_until_it_is_validated(client: isomatch.Client) -> None:
    mesh = blob_meshes()[0]
    assert client.upload((mesh.vertices, mesh.faces[:1000])).faces == 1000


def test_what_is_refused_later_is_refused(client: isomatch.Client) -> None:
    with pytest.raises(isomatch.UnprocessableShape):
        client.upload((np.zeros((3, 3)), [[0, 1, 2]]))


def test_an_upload_is_waited_for_so_long_and_no_longer(client: isomatch.Client) -> None:
    mesh = blob_meshes()[1]
    with pytest.raises(isomatch.WaitTimeout, match="reading blob did not end"):
        client.upload((mesh.vertices, mesh.faces[:900]), name="blob", timeout=0.0)
    assert client.upload((mesh.vertices, mesh.faces[:900])).name == "blob"


def test_a_file_over_the_limit(client: isomatch.Client, tmp_path: Path) -> None:
    path = tmp_path / "large.off"
    path.write_bytes(b"OFF\n" + b"#" * LIMIT)
    with pytest.raises(isomatch.TooLarge, match=str(LIMIT)) as refusal:
        client.upload(path)
    assert refusal.value.status == 413
