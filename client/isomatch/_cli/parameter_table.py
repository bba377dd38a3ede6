"""Parameters of jobs as options of a command, built from a table."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final

import typer

from isomatch._cli.options import landmarks, structure_choices

_TYPES: Final[dict[str, Any]] = {
    "integer": int,
    "number": float,
    "boolean": bool,
    "string": str,
    "structure": str,
    "structures": list[str],
    "landmarks": list[str],
}
_FORMS: Final = {
    "structure": " As in {example}; `isomatch structures` lists them.",
    "structures": " As in {example}, may be repeated; `isomatch structures` lists them.",
    "landmarks": " SOURCE:TARGET, as in 17:203; repeat the option for each pair.",
}


@dataclass(frozen=True)
class ParameterOption:
    """A parameter as an option.

    Parameters
    ----------
    name
        Name of the parameter.
    kind
        "integer", "number", "boolean", "string", "structure", "structures" or "landmarks".
    help
        Summary with range and default.
    topic
        Heading under which ``--help`` shows it; "" for the first.
    """

    name: str
    kind: str
    help: str
    topic: str

    @property
    def flag(self) -> str:
        """The option as it is given; one for each entry of a list."""
        flag = "--" + self.name.replace("_", "-")
        return flag.removesuffix("s") if self.kind == "landmarks" else flag

    @property
    def argument(self) -> inspect.Parameter:
        """The option as an argument of a command."""
        flag = self.flag
        if self.kind == "boolean":
            flag += "/--no-" + self.name.replace("_", "-")
        example = "hks:times=0.1,1" if self.name == "descriptor" else "diffusion:time=0.02"
        form = _FORMS.get(self.kind, "").format(example=example)
        option = typer.Option(flag, help=self.help + form, rich_help_panel=self.topic or None)
        return inspect.Parameter(
            self.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None,
            annotation=Annotated[_TYPES[self.kind] | None, option],
        )

    def value(self, given: Any) -> Any:
        """Return the parameter's value for that of the option; None if it was not given."""
        if given is None or given == []:
            return None
        if self.kind == "structure":
            return structure_choices([given])[0]
        if self.kind == "structures":
            return structure_choices(given)
        return landmarks(given) if self.kind == "landmarks" else given


def takes(
    options: Sequence[ParameterOption], without: Sequence[str] = ()
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorate a command, whose argument `parameters` becomes one option for each parameter.

    Parameters
    ----------
    options
        The parameters.
    without
        Names of those that the command has options of its own for.
    """
    known = {one.name: one for one in options if one.name not in without}

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        def call(**given: Any) -> None:
            found = {name: known[name].value(given.pop(name)) for name in known}
            parameters = {name: value for name, value in found.items() if value is not None}
            command(parameters=parameters, **given)

        arguments: list[inspect.Parameter] = []
        for own in inspect.signature(command).parameters.values():
            replaced = [one.argument for one in known.values()]
            kept = [own.replace(kind=inspect.Parameter.KEYWORD_ONLY)]
            arguments += replaced if own.name == "parameters" else kept
        call.__name__, call.__doc__ = command.__name__, command.__doc__
        # typer reads the options from the signature, which functions do not have by their type.
        call.__signature__ = inspect.Signature(arguments)  # type: ignore[attr-defined]
        return call

    return decorate
