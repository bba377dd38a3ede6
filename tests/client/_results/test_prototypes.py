"""Prototypes through the clients and the command line, against the running service."""

import asyncio
import io
import json
from pathlib import Path

import isomatch
import numpy as np
import pytest

from tests.client.command_line import run
from tests.worker.families import family


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Five files of one connectivity, and one more that nothing is learned from."""
    folder = tmp_path_factory.mktemp("family")
    paths = []
    for number, data in enumerate(family(6, first=100)):
        paths.append(folder / f"blob{number}.off")
        paths[-1].write_bytes(data)
    return paths


def test_a_prototype(client: isomatch.Client, meshes: list[Path], tmp_path: Path) -> None:
    shapes = [client.upload(mesh) for mesh in meshes]
    job = client.learn_prototype(
        shapes[:5], name="sdk", reference=shapes[1], correspondence="shared_connectivity",
        points=8, components=2, eigenpairs=30,
    )  # fmt: skip
    learned = job.result(progress=True, timeout=240)
    prototype = learned.prototype
    assert job.kind == "prototype"
    assert (prototype.name, prototype.version, prototype.points) == ("sdk", 1, 8)
    assert (prototype.examples, prototype.reference) == (5, shapes[1].id)
    assert prototype.learned_from is not None
    assert all(example.used for example in prototype.learned_from)
    assert learned.parameters["correspondence"] == "shared_connectivity"
    assert client.prototype(prototype.id) == prototype
    assert prototype in list(client.prototypes())
    assert list(client.prototypes("sdk")) == [prototype]
    assert isinstance(client.job(job.id).result(), isomatch.LearnedPrototype)
    with pytest.raises(isomatch.Conflict, match="no picture"):
        job.picture()

    match = client.match(prototype, shapes[5]).result(timeout=240)
    assert (match.source, match.source_kind) == (prototype.id, "prototype")
    assert sorted(match.pairs[:, 0]) == list(range(8))

    path = tmp_path / "sdk.npz"
    client.download_prototype(prototype, path)
    with np.load(path, allow_pickle=False) as arrays:
        assert arrays["positions"].shape == (8, 3)
    client.delete_prototype(prototype)
    with pytest.raises(isomatch.NotFound):
        client.prototype(prototype.id)
    with pytest.raises(isomatch.UnknownPrototype):
        client.match(prototype, shapes[5])
    with path.open("rb") as file:
        again = client.upload_prototype(file)
    assert (again.id, again.name, again.version) == (prototype.id, "sdk.npz"[:-4], 2)
    assert client.upload_prototype(path.read_bytes(), "other") == again
    found = client.match(again.id, shapes[5]).result(timeout=240)
    assert (found.pairs == match.pairs).all()


def test_correspondences_are_arrays_or_lists(client: isomatch.Client, meshes: list[Path]) -> None:
    shapes = [client.upload(mesh) for mesh in meshes[:3]]
    vertices = np.tile([3, 77, 41, 150], (3, 1))
    job = client.learn_prototype(shapes, vertices, name="given", components=1, metric="geodesic")
    prototype = job.result(timeout=240).prototype
    assert (prototype.points, prototype.examples) == (4, 3)


def test_refusals(client: isomatch.Client, meshes: list[Path]) -> None:
    shapes = [client.upload(mesh) for mesh in meshes[:2]]
    with pytest.raises(TypeError, match="learn_prototype"):
        client.learn_prototype(shapes, point=6)  # type: ignore[call-arg]
    with pytest.raises(isomatch.InvalidRequest) as refused:
        client.learn_prototype(shapes[:1] * 2)
    assert [wrong.field for wrong in refused.value.errors] == ["body.shapes.1"]
    with pytest.raises(isomatch.UnknownShape):
        client.learn_prototype([*shapes, "nobody"])
    for odd in (b"no prototype", io.BytesIO(b"PK")):
        with pytest.raises(isomatch.UnprocessablePrototype):
            client.upload_prototype(odd)
    with pytest.raises(TypeError, match="a prototype is"):
        client.upload_prototype(3)  # type: ignore[arg-type]


def test_prototypes_of_the_async_client(url: str, meshes: list[Path], tmp_path: Path) -> None:
    async def program() -> None:
        async with isomatch.AsyncClient(url) as client:
            shapes = await asyncio.gather(*map(client.upload, meshes[:3]))
            job = await client.learn_prototype(
                shapes, name="async", points=6, components=1, eigenpairs=30
            )
            prototype = (await job.result()).prototype
            assert await client.prototype(prototype.id) == prototype
            assert [found.id async for found in client.prototypes("async")] == [prototype.id]
            await client.download_prototype(prototype, tmp_path / "async.npz")
            await client.delete_prototype(prototype)
            again = await client.upload_prototype(tmp_path / "async.npz")
            assert again.id == prototype.id

    asyncio.run(program())


def test_the_commands(url: str, meshes: list[Path], tmp_path: Path) -> None:
    options = ["--points", "8", "--components", "2", "--eigenpairs", "30", "--name", "shell"]
    done = run("prototype", "learn", *meshes[:5], "--shared-connectivity", *options, url=url)
    assert done.returncode == 0, done.stderr
    for word in ("shell", "geodesic", "si_hks", "examples", "seconds"):
        assert word in done.stdout
    first = run("prototype", "list", "--name", "shell", "-q", url=url).stdout.strip()
    assert first in done.stdout
    metric = ["--metric", "commute_time", "--descriptor", "none", "--shared-connectivity"]
    plain = run("prototype", "learn", *meshes[:4], *options, *metric, "--json", url=url)
    second = json.loads(plain.stdout)["prototype"]
    assert (second["name"], second["version"]) == ("shell", 2)
    table = run("prototype", "list", "--name", "shell", url=url).stdout
    assert first in table
    assert second["id"] in table
    assert "commute_time" in run("prototype", "show", second["id"], url=url).stdout

    file = tmp_path / "shell.npz"
    assert run("prototype", "download", first, file, url=url).returncode == 0
    picture = tmp_path / "match.png"
    matched = run("match", first, meshes[5], "--json", "--picture", picture, url=url)
    assert matched.returncode == 0, matched.stderr
    assert json.loads(matched.stdout)["source_kind"] == "prototype"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert run("prototype", "delete", first, second["id"], url=url).returncode == 0
    gone = run("match", first, meshes[5], url=url)
    assert (gone.returncode, gone.stdout) == (1, "")
    uploaded = run("prototype", "upload", file, "--json", url=url)
    assert json.loads(uploaded.stdout)["id"] == first
    wrong = run("prototype", "upload", meshes[0], url=url)
    assert wrong.returncode == 1
    assert f"isomatch: {meshes[0]}: not a prototype" in wrong.stderr
    np.savez(tmp_path / "maps.npz", map_0_1=np.arange(3))
    wrong = run("prototype", "upload", tmp_path / "maps.npz", url=url)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "is no prototype: it has no array 'about'" in " ".join(
        wrong.stderr.replace("│", " ").split()
    )
    assert run("match", "p-1234", meshes[5], url=url).returncode == 2
