"""What tools say of their parameters is what the service declares."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from isomatch import AsyncClient
from isomatch._mcp.folder import Folder
from isomatch._mcp.server import server
from pydantic import BaseModel

from broker.contracts import DissimilarityParameters, MatchParameters
from codegen.described import described


@pytest.mark.parametrize(
    ("tool", "model"), [("match", MatchParameters), ("compare", DissimilarityParameters)]
)
def test_ranges_defaults_and_choices_are_those_of_the_service(
    tool: str, model: type[BaseModel], tmp_path: Path
) -> None:
    properties = asyncio.run(_properties(tool, tmp_path))
    declared = {one.name: one for one in described(model) if one.name in properties}
    assert declared
    for name, one in declared.items():
        ours = properties[name]
        assert ours.get("default") in (one.default, None, ()), name
        assert tuple(ours.get("enum", ())) == one.values, name
        if one.limits:
            stated = f", {one.limits}"
            if one.default not in (None, ()):
                stated += f"; {one.default} if left out"
            assert stated in ours["description"], name


async def _properties(tool: str, folder: Path) -> dict[str, Any]:
    """The parameters of a tool by name, as programs are told them."""
    async with AsyncClient("http://127.0.0.1:9") as client:
        tools = await server(client, Folder(folder)).list_tools()
    (found,) = (one for one in tools if one.name == tool)
    properties: dict[str, Any] = found.input_schema["properties"]
    return properties
