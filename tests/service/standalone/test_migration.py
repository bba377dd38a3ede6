"""The service with a Redis of its own moves what an earlier version kept there when it starts."""

from pathlib import Path

from broker.store import DEFAULT_KEYS, connect
from service.standalone import EmbeddedServer
from tests.service.standalone.test_standalone import service
from tests.worker.records import shape_record

SHAPE = "a" * 32


def test_an_earlier_data_directory_is_migrated(tmp_path: Path) -> None:
    data = tmp_path / "data"
    server = EmbeddedServer(data / "redis")
    server.start()
    with connect(server.url, retry_seconds=5) as client:
        client.set(DEFAULT_KEYS.shape(SHAPE), shape_record(SHAPE).model_dump_json(), ex=1000)
        client.set(DEFAULT_KEYS.shape_upload(SHAPE), b"as it was uploaded", ex=1000)
    server.stop()
    for name in ("redis", "blobs"):
        (data / name).mkdir(exist_ok=True)
        (data / name).chmod(0o755)
    for _ in range(2):
        with service(data, tmp_path / "log", ISOMATCH_WORKERS="0") as running:
            mesh = running.http.get(f"/v1/shapes/{SHAPE}/mesh")
            assert (mesh.status_code, mesh.content) == (200, b"as it was uploaded")
            running.end()
    (blob,) = data.glob("blobs/*/shape!*")
    assert blob.read_bytes() == b"as it was uploaded"
    for name in ("redis", "blobs"):
        assert (data / name).stat().st_mode & 0o777 == 0o700
