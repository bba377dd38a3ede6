"""Tools that refuse unknown arguments, and say in plain words what is wrong with others."""

import inspect
import json
from collections.abc import Callable, Mapping
from types import new_class
from typing import Any

from mcp.server.mcpserver import Context
from mcp.server.mcpserver.exceptions import ToolError
from mcp.server.mcpserver.tools import Tool
from mcp_types import TextContent, ToolAnnotations
from pydantic import ValidationError


class StrictTool(Tool):
    """A tool that refuses arguments that it does not have.

    The protocol's library drops them, so an answer would seem to have used them.
    """

    @classmethod
    def of(cls, method: Callable[..., Any], annotations: ToolAnnotations) -> Tool:
        """Return a tool that calls a method, with its docstring as description."""
        tool = cls.from_function(
            method, description=inspect.getdoc(method), annotations=annotations
        )
        model = tool.fn_metadata.arg_model
        tool.fn_metadata.arg_model = new_class(model.__name__, (model,), {"extra": "forbid"})
        tool.parameters = tool.fn_metadata.arg_model.model_json_schema(by_alias=True)
        return tool

    async def run(
        self, arguments: dict[str, Any], context: Context[Any, Any], convert_result: bool = False
    ) -> Any:
        """Check the arguments, and call the method; texts are without indentation."""
        try:
            self.fn_metadata.validate_arguments(arguments)
        except ValidationError as error:
            raise ToolError(f"Error executing tool {self.name}: {self._said(error)}") from error
        answer = await super().run(arguments, context, convert_result)
        if not convert_result or answer.structured_content is None:
            return answer
        # The protocol's library indents the text, with one number on a line.
        text = json.dumps(answer.structured_content, ensure_ascii=False, separators=(",", ":"))
        return answer.model_copy(update={"content": [TextContent(type="text", text=text)]})

    def _said(self, error: ValidationError) -> str:
        """The paths of wrong arguments and what is wrong, without a text of pydantic."""
        known = ", ".join(self.fn_metadata.arg_model.model_fields)
        wrong = error.errors(include_url=False, include_input=False)
        return "\n".join(_line(one, known) for one in wrong)


def _line(wrong: Mapping[str, Any], known: str) -> str:
    path = ".".join(map(str, wrong["loc"]))
    if wrong["type"] == "extra_forbidden":
        return f"{path}: there is no such argument; the tool takes {known}"
    return f"{path}: {wrong['msg']}"
