"""The tools, used by a client of the protocol over the standard input and output."""

import asyncio
import base64
import json
import os
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import isomatch
import numpy as np
import pytest
from mcp import Client, StdioServerParameters
from mcp_types import CallToolResult, ImageContent, TextContent

from tests.client.command_line import COMMAND
from tests.client.shapes import blob_meshes, write_blobs

QUICK = {"points": 8}
LONG = {"points": 256, "time_limit": 600}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with ``a.off`` and ``b.obj``."""
    root = tmp_path / "meshes"
    root.mkdir()
    write_blobs(root)
    return root


def program(folder: Path, url: str) -> StdioServerParameters:
    """The command as a desktop program starts it."""
    environment = {**os.environ, "ISOMATCH_URL": url}
    command, *words = COMMAND
    return StdioServerParameters(
        command=command, args=[*words, "mcp", "--root", str(folder)], env=environment
    )


@asynccontextmanager
async def connected(folder: Path, url: str) -> AsyncIterator[Client]:
    async with Client(program(folder, url)) as client:
        yield client


def used(folder: Path, url: str, use: Callable[[Client], Awaitable[None]]) -> None:
    """Run a use of the server."""

    async def run() -> None:
        async with connected(folder, url) as client:
            await use(client)

    asyncio.run(run())


def text(result: CallToolResult) -> str:
    (block,) = result.content
    assert isinstance(block, TextContent)
    return block.text


def answer(result: CallToolResult) -> dict[str, Any]:
    """The structured content of a result that is no error, and short."""
    assert not result.is_error, result.content
    content = result.structured_content
    assert isinstance(content, dict)
    assert len(json.dumps(content)) < 8000
    return content


def refusal(result: CallToolResult) -> str:
    assert result.is_error
    return text(result)


def test_from_meshes_to_carried_labels(url: str, folder: Path) -> None:
    count = _uploaded(url, folder / "a.off").vertices
    labels = np.arange(count) % 5
    np.savez(folder / "labels.npz", parts=labels)

    async def use(client: Client) -> None:
        tools = {tool.name: tool for tool in (await client.list_tools()).tools}
        assert {*tools} == {"upload", "match", "compare", "transfer", "picture"}
        assert all(tool.description and "context" not in str(tool) for tool in tools.values())

        shape = answer(await client.call_tool("upload", {"path": "a.off"}))
        assert shape["vertices"] == count

        told: list[tuple[float, float | None]] = []

        async def report(
            progress: float, total: float | None, message: str | None, **_: object
        ) -> None:
            told.append((progress, total))

        arguments = {"source": shape["id"], "target": "b.obj", "dense": True, **QUICK}
        called = client.call_tool(
            "match", {**arguments, "save_to": "match.npz"}, progress_callback=report
        )
        match = answer(await called)
        assert told == sorted(told)
        assert told[-1] == (1.0, 1.0)
        assert match["points"] == 8
        assert match["dense"]
        assert match["certificate"]["lower_bound"] <= match["energy"] + 1e-9
        assert "not that the answer is right" in match["certificate"]["scope"]
        assert 0.0 < match["confidence"]["probability"] < 1.0
        assert match["file"] == "match.npz"
        assert np.load(folder / "match.npz").files

        arguments = {"match": match["job"], "what": "labels", "values": "labels.npz"}
        carried = answer(
            await client.call_tool("transfer", {**arguments, "save_to": "carried.npz"})
        )
        assert carried["attributes"] == ["parts"]
        values = np.load(folder / "carried.npz")["parts"]
        assert len(values) == carried["rows"]
        assert {*values} <= {*labels}
        assert "save_to" in refusal(await client.call_tool("transfer", arguments))

        arguments = {"match": match["job"], "what": "landmarks", "landmarks": [0, 7]}
        result = await client.call_tool("transfer", arguments)
        carried = answer(result)
        assert text(result) == json.dumps(carried, ensure_ascii=False, separators=(",", ":"))
        assert carried["confidence"] == match["confidence"]
        assert len(carried["points"]) == 2
        places = np.array([point["position"] for point in carried["points"]])
        vertices = [point["vertex"] for point in carried["points"]]
        near = blob_meshes()[1].vertices[vertices]
        assert np.linalg.norm(places - near, axis=1).max() < 0.2
        assert all(0.0 <= point["confidence"] <= 1.0 for point in carried["points"])

        (image,) = (await client.call_tool("picture", {"job": match["job"]})).content
        assert isinstance(image, ImageContent)
        assert image.mime_type == "image/png"
        assert base64.b64decode(image.data).startswith(b"\x89PNG")

    used(folder, url, use)


def _uploaded(url: str, path: Path) -> isomatch.Shape:
    with isomatch.Client(url) as client:
        return client.upload(path)


def test_a_comparison(url: str, folder: Path) -> None:
    copy = (folder / "a.off").read_text() + "# the same surface in another file\n"
    (folder / "copy.off").write_text(copy)

    async def use(client: Client) -> None:
        arguments = {"shapes": ["a.off", "b.obj", "copy.off"], "save_to": "matrix.csv"}
        found = answer(await client.call_tool("compare", {**arguments, "points": 4}))
        matrix = np.array(found["matrix"])
        assert np.array_equal(matrix, matrix.T)
        assert matrix[0, 2] == pytest.approx(0.0, abs=1e-9)
        assert [shape["name"] for shape in found["shapes"]] == ["a.off", "b.obj", "copy.off"]
        assert found["shapes"][0]["nearest"] == ["copy.off", "b.obj"]
        assert found["shapes"][0]["dissimilarities"] == [matrix[0, 2], matrix[0, 1]]
        assert (folder / "matrix.csv").read_text().count("\n") >= 3

    used(folder, url, use)


def test_refusals_name_the_field_and_what_to_do(url: str, folder: Path) -> None:
    (folder.parent / "outside.off").write_text("OFF 0 0 0\n")
    (folder / "link.off").symlink_to(folder.parent / "outside.off")
    (folder / "broken.off").write_text("OFF 3 1 0\n0 0 0\n")

    async def use(client: Client) -> None:
        async def refused(tool: str, **arguments: Any) -> str:
            return refusal(await client.call_tool(tool, arguments))

        for path in ("../outside.off", "link.off", str(folder.parent / "outside.off")):
            assert "outside" in await refused("upload", path=path)
            assert "outside" in await refused("match", source=path, target="b.obj")
            assert "outside" in await refused("compare", shapes=["b.obj", path])
        assert "broken.off" not in await refused("upload", path="missing.off")
        assert await refused("upload", path="broken.off")
        assert "points" in await refused("match", source="a.off", target="b.obj", points="many")
        said = await refused("match", source="a.off", target="b.obj", points=2)
        assert "body.points: " in said
        said = await refused("match", source="0" * 32, target="b.obj")
        assert "Upload the files again" in said
        assert "Upload" in await refused("picture", job="0" * 32)
        assert "is no id" in await refused("picture", job="../../v1/shapes")
        exists = {"source": "a.off", "target": "b.obj", "save_to": "a.off"}
        assert "overwritten" in await refused("match", **exists)

    used(folder, url, use)


def test_without_a_service_the_error_says_how_to_start_one(folder: Path) -> None:
    async def use(client: Client) -> None:
        said = refusal(await client.call_tool("upload", {"path": "a.off"}))
        assert "isomatch serve" in said

    used(folder, "http://127.0.0.1:9", use)


def test_a_cancelled_call_cancels_its_job(url: str, folder: Path) -> None:
    async def use(client: Client) -> None:
        source = answer(await client.call_tool("upload", {"path": "a.off"}))["id"]
        before = await jobs(url, source)
        arguments = {"source": source, "target": "b.obj", **LONG}
        call = asyncio.ensure_future(client.call_tool("match", arguments))
        job = await started(url, source, before)
        call.cancel()
        with pytest.raises(asyncio.CancelledError):
            await call
        assert await ended(url, job) == "cancelled"
        # The server still answers.
        answer(await client.call_tool("upload", {"path": "a.off"}))

    used(folder, url, use)


@pytest.mark.parametrize("end", ["leaves", "SIGTERM"])
def test_what_ends_the_server_cancels_its_jobs(url: str, folder: Path, end: str) -> None:
    first: dict[str, Any] = {"clientInfo": {"name": "test", "version": "1"}, "capabilities": {}}
    first["protocolVersion"] = "2025-06-18"
    arguments = {"source": "a.off", "target": "b.obj", **LONG}
    messages: list[dict[str, Any]] = [
        {"id": 1, "method": "initialize", "params": first},
        {"method": "notifications/initialized"},
        {"id": 2, "method": "tools/call", "params": {"name": "match", "arguments": arguments}},
    ]

    async def run() -> None:
        source = _uploaded(url, folder / "a.off").id
        before = await jobs(url, source)
        process = subprocess.Popen(
            [*COMMAND, "mcp", "--root", str(folder), "--url", url],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
        )
        assert process.stdin is not None
        for message in messages:
            process.stdin.write(json.dumps({"jsonrpc": "2.0", **message}).encode() + b"\n")
        process.stdin.flush()
        job = await started(url, source, before)
        if end == "leaves":
            process.stdin.close()
        else:
            process.send_signal(signal.SIGTERM)
        assert await asyncio.to_thread(process.wait, 60) == (0 if end == "leaves" else 143)
        if end != "leaves":
            process.stdin.close()
        assert await ended(url, job) == "cancelled"

    asyncio.run(run())


async def jobs(url: str, source: str) -> set[str]:
    async with isomatch.AsyncClient(url) as client:
        return {job.id async for job in client.jobs(of=source)}


async def started(url: str, source: str, before: set[str]) -> str:
    """Wait for a job of a shape that is new, and return its id."""
    while not (new := await jobs(url, source) - before):
        await asyncio.sleep(0.05)
    (job,) = new
    return job


async def ended(url: str, job: str) -> str:
    async with isomatch.AsyncClient(url) as client:
        return (await (await client.job(job)).wait(timeout=60)).state


def test_without_the_extra_the_command_says_what_to_install(tmp_path: Path) -> None:
    # The package is hidden from a process of its own.
    script = "import sys; sys.modules['mcp'] = None; from isomatch.cli import app; app(['mcp'])"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr == "isomatch: mcp is not installed: pip install 'isomatch[mcp]'\n"


def test_other_commands_do_not_import_it() -> None:
    script = "import sys, isomatch.cli; print([name for name in sys.modules if 'mcp' in name])"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "['isomatch._cli.mcp_command']\n"
