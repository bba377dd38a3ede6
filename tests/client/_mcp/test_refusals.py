"""What the tools refuse before a job starts, and say of a result; without a service."""

import asyncio
import json
from pathlib import Path
from typing import Any

import isomatch
import pytest
from isomatch._mcp.answers import MOST_LINES, CarriedPoint, transfer_answer
from isomatch._mcp.folder import Folder
from isomatch._mcp.server import server
from isomatch._mcp.tools import Tools
from isomatch._problem import Problem
from mcp import Client
from mcp.server.mcpserver.exceptions import ToolError
from mcp_types import TextContent, Tool

from service.http.openapi.examples import EXAMPLES

TRANSFER = EXAMPLES["answers"]["get_result"]["200"]["transfer"]
NOBODY = "http://127.0.0.1:9"
PAIR = {"source": "a.off", "target": "b.off"}


def said(root: Path, tool: str, **arguments: Any) -> str:
    """The refusal of a call, in a folder with ``a.off`` and ``b.off``."""
    for name in ("a.off", "b.off"):
        (root / name).write_text("OFF 0 0 0\n")

    async def call() -> str:
        async with isomatch.AsyncClient(NOBODY) as client, Client(_server(client, root)) as model:
            result = await model.call_tool(tool, arguments)
            (block,) = result.content
            assert result.is_error
            assert isinstance(block, TextContent)
            return block.text

    return asyncio.run(call())


def _server(client: isomatch.AsyncClient, root: Path) -> Any:
    return server(client, Folder(root))


def test_unknown_arguments_are_named_with_the_known_ones(tmp_path: Path) -> None:
    message = said(tmp_path, "match", **PAIR, refine="gmds", metric="geodesic")
    assert "refine: there is no such argument; the tool takes source, target, dense, " in message
    assert "metric: there is no such argument" in message


def test_values_of_a_wrong_type_are_refused_in_plain_words(tmp_path: Path) -> None:
    message = said(tmp_path, "match", source="a.off", points="many", landmarks="17:203")
    assert message.splitlines() == [
        "Error executing tool match: target: Field required",
        "points: Input should be a valid integer, unable to parse string as an integer",
        "landmarks: Input should be a valid list",
    ]


def test_schemas_take_no_other_arguments_and_texts_no_indentation(tmp_path: Path) -> None:
    async def tools() -> list[Tool]:
        async with isomatch.AsyncClient(NOBODY) as client, Client(_server(client, tmp_path)) as one:
            return (await one.list_tools()).tools

    for tool in asyncio.run(tools()):
        assert tool.input_schema["additionalProperties"] is False
        assert "\n " not in str(tool.description)


@pytest.mark.parametrize(
    ("tool", "arguments", "message"),
    [
        ("match", {**PAIR, "save_to": "m.ply"}, ".ply shows a map of all vertices; set `dense`"),
        ("match", {**PAIR, "save_to": "m.zip"}, "this result has no .zip file: give .json, .npz"),
        ("compare", {"shapes": ["a.off", "b.off"], "save_to": "c.ply"}, "has no .ply file"),
        ("transfer", {"match": "0" * 32, "what": "uv", "save_to": "t.ply"}, "has no .ply file"),
    ],
)
def test_endings_that_a_result_does_not_have(
    tmp_path: Path, tool: str, arguments: dict[str, Any], message: str
) -> None:
    assert message in said(tmp_path, tool, **arguments)


@pytest.mark.parametrize("reason", ["no file of this format", "was made meanwhile"])
def test_a_result_that_is_not_written_names_its_job(tmp_path: Path, reason: str) -> None:
    class Job:
        id = "a8ba"

        async def save(self, path: Path) -> None:
            if "format" in reason:
                raise isomatch.Conflict(Problem(title="Conflict", status=409, detail=reason))
            path.write_text("pairs")
            (tmp_path / "m.csv").touch()

    async def save() -> None:
        async with isomatch.AsyncClient(NOBODY) as client:
            found = isomatch.Transfer.from_json(json.dumps(TRANSFER))
            await Tools(client, Folder(tmp_path))._save(Job(), found, tmp_path / "m.csv")

    with pytest.raises(ToolError, match=f"job a8ba has succeeded, but .*{reason}"):
        asyncio.run(save())


def test_a_document_at_hand_is_not_requested_again(tmp_path: Path) -> None:
    found = isomatch.Transfer.from_json(json.dumps(TRANSFER))

    async def save() -> str | None:
        async with isomatch.AsyncClient(NOBODY) as client:
            return await Tools(client, Folder(tmp_path))._save(None, found, tmp_path / "t.json")

    assert asyncio.run(save()) == "t.json"
    assert (tmp_path / "t.json").read_bytes() == found.to_json()


def test_landmarks_that_are_not_listed_are_counted() -> None:
    point = {"vertices": [1, 2, 3], "weights": [0.0, 0.75, 0.25], "position": [1 / 3, 0.0, 2e9]}
    many = {"what": "landmarks", "rows": 0, "points": [point, None] * 30, "attributes": []}
    found = isomatch.Transfer.from_json(json.dumps({**TRANSFER, **many}))
    answer = transfer_answer("a8ba", found, None)
    assert answer.rows == 60
    assert answer.points is not None
    assert (len(answer.points), answer.points_not_listed) == (MOST_LINES, 10)
    carried = CarriedPoint(vertex=2, position=(0.333333, 0.0, 2e9), confidence=None)
    assert answer.points[:2] == (carried, None)
    values = isomatch.Transfer.from_json(json.dumps({**TRANSFER, "points": None, "rows": 642}))
    answer = transfer_answer("a8ba", values, None)
    assert (answer.rows, answer.points, answer.points_not_listed) == (642, None, 0)
