"""The commands, and errors of usage with ``--json``: problem documents, as all other errors."""

import json
import sys
from collections.abc import Sequence
from contextvars import ContextVar
from typing import Any, Final, NoReturn

import typer
from typer.core import TyperGroup

# typer exports no base class of its errors of usage; it has had a click of its own since 0.26.
_UsageError: Final[Any] = typer.BadParameter.__base__


_running: Final[ContextVar[Any]] = ContextVar("running command", default=None)


def running_options() -> frozenset[str]:
    """Return the options of the running command, such as ``"--points"``."""
    parameters = () if (command := _running.get()) is None else command.params
    return frozenset(flag for one in parameters for flag in one.opts if flag.startswith("--"))


class Commands(TyperGroup):
    """The commands; with ``--json`` an error of usage is a problem document."""

    def main(self, args: Sequence[str] | None = None, *others: Any, **named: Any) -> Any:
        """Run a command line, as the class above does."""
        words = sys.argv[1:] if args is None else args
        if "--json" not in words:
            return super().main(args, *others, **named)
        try:
            code = super().main(args, *others, **named | {"standalone_mode": False})
        except _UsageError as error:
            _report(error)
        sys.exit(code or 0)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that a command line names, which runs from here on."""
        name, command, rest = super().resolve_command(ctx, args)
        if not ctx.resilient_parsing:
            _refuse_options_before(ctx, command)
        _running.set(command)
        return name, command, rest


def _refuse_options_before(ctx: Any, command: Any) -> None:
    """Refuse options before the name of a command, which it would not get."""
    for option in ctx.command.params:
        source = ctx.get_parameter_source(option.name)
        if source is not None and source.name == "COMMANDLINE":
            taken = option.name in {one.name for one in command.params}
            advice = "give it after" if taken else "leave it out of"
            raise typer.BadParameter(f"{advice} `{command.name}`", ctx=ctx, param=option)


def _report(error: Any) -> NoReturn:
    document = {
        "type": "urn:isomatch:client:wrong-usage",
        "title": "Wrong usage",
        "detail": " ".join(error.format_message().split()),
    }
    typer.echo(json.dumps(document), err=True)
    sys.exit(error.exit_code)
