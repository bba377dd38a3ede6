"""A service that takes small files only, lets nobody wait for their validation, and wants a key."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import isomatch
import numpy as np
import pytest

from demo.stack import running_stack
from tests.client.shapes import blob_meshes
from tests.receiver import receiving
from tests.waiting import until

LIMIT = 30_000
SETTINGS = {
    "ISOMATCH_VALIDATION_WAIT": "0",
    "ISOMATCH_MAX_UPLOAD_BYTES": str(LIMIT),
    "ISOMATCH_WORKERS": "1",
    "ISOMATCH_API_KEYS": "alice:the-key-of-alice",
    "ISOMATCH_WEBHOOK_NETWORKS": "127.0.0.0/8",
    "ISOMATCH_WEBHOOK_PAUSE": "0.1",
}


@pytest.fixture(scope="module")
def client() -> Iterator[isomatch.Client]:
    with (
        running_stack(SETTINGS) as stack,
        isomatch.Client(stack.url, api_key="the-key-of-alice") as client,
    ):
        yield client


def test_an_upload_waits_until_it_is_validated(client: isomatch.Client) -> None:
    mesh = blob_meshes()[0]
    assert client.upload((mesh.vertices, mesh.faces[:1000])).faces == 1000


def test_refusals_after_the_upload(client: isomatch.Client) -> None:
    with pytest.raises(isomatch.UnprocessableShape):
        client.upload((np.zeros((3, 3)), [[0, 1, 2]]))


def test_the_timeout_of_an_upload(client: isomatch.Client) -> None:
    mesh = blob_meshes()[1]
    late = ""
    # One may be read before it is answered, where the worker is quicker than the service.
    for count in range(900, 950):
        part = (mesh.vertices, mesh.faces[:count])
        try:
            client.upload(part, name="blob", timeout=0.0)
        except isomatch.WaitTimeout as error:
            late = str(error)
            break
    assert "reading blob did not end" in late
    assert client.upload(part).name == "blob"


def test_a_file_above_the_limit(client: isomatch.Client, tmp_path: Path) -> None:
    path = tmp_path / "large.off"
    path.write_bytes(b"OFF\n" + b"#" * LIMIT)
    with pytest.raises(isomatch.TooLarge, match=r"limit is 0\.03 MB") as refusal:
        client.upload(path)
    assert refusal.value.status == 413


@pytest.mark.parametrize("key", [None, "the-key-of-bob"])
def test_a_missing_api_key_is_named(client: isomatch.Client, key: str | None) -> None:
    with (
        isomatch.Client(client.base_url, api_key=key) as stranger,
        pytest.raises(isomatch.Unauthorized, match="API key"),
    ):
        stranger.upload(b"OFF", file_type="off")


def test_a_command_names_the_variable_of_the_key(client: isomatch.Client) -> None:
    command = [sys.executable, "-m", "isomatch_command", "shapes", "--url", client.base_url]
    environment = {name: value for name, value in os.environ.items() if name != "ISOMATCH_API_KEY"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert "ISOMATCH_API_KEY" in done.stderr


def test_a_webhook_is_sent(client: isomatch.Client) -> None:
    mesh = blob_meshes()[0]
    shape = client.upload((mesh.vertices, mesh.faces[:1000]))
    secret = "known to both of them"
    with receiving() as receiver:
        receiver.answers = [500]
        hook: isomatch.Webhook = {"url": f"http://127.0.0.1:{receiver.port}/", "secret": secret}
        job = client.match(shape, shape, points=8, orientation=False, webhook=hook).wait()
        assert job.caller == "alice"
        first, second = receiver.wait(2)
        for request in (first, second):
            signature = request.headers["isomatch-signature"]
            told = isomatch.verify_webhook(request.body, signature, secret)
            assert (told.job.id, told.job.state) == (job.id, job.state)

        def delivered() -> isomatch.JobWebhook | None:
            told = job.refresh().webhook
            return told if told is None or told.state != "pending" else None

        webhook = until(delivered, pause=0.05)
    assert (webhook.state, webhook.attempts, webhook.status) == ("delivered", 2, 204)
