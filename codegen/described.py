"""Parameters of jobs as their contracts describe them."""

import re
from dataclasses import dataclass
from typing import Any, Final

from pydantic import BaseModel

from broker.contracts import DissimilarityParameters, MatchParameters, PrototypeParameters
from broker.contracts.strict import Topic

TOPICS: Final = ("", "Shapes", "Structures", "Solver", "Mixtures")
"""Headings of parameters, in the order in which they are shown."""


@dataclass(frozen=True)
class Job:
    """A kind of job that has parameters.

    Parameters
    ----------
    name
        Name of its table of parameters.
    model
        Contract of its parameters.
    method
        Method of the client that asks for it.
    title
        Heading in the documents.
    """

    name: str
    model: type[BaseModel]
    method: str
    title: str


JOBS: Final = (
    Job("MATCH", MatchParameters, "match", "Match"),
    Job("COMPARE", DissimilarityParameters, "dissimilarities", "Dissimilarities"),
    Job("LEARN", PrototypeParameters, "learn_prototype", "Prototype"),
)


@dataclass(frozen=True)
class Described:
    """A parameter of a job.

    Parameters
    ----------
    name, description, default, topic
        As declared.
    kind
        "integer", "number", "boolean", "string", "structure", "structures" or "landmarks".
    nullable
        Whether it may be null.
    schema
        JSON schema of a value that is not null.
    """

    name: str
    kind: str
    nullable: bool
    default: Any
    description: str
    topic: str
    schema: dict[str, Any]

    @property
    def summary(self) -> str:
        """The first sentence of the description, without source and full stop."""
        first = first_sentence(self.description)
        return re.sub(r" \((section|\w+ of)\b.*\)\.$", ".", first).removesuffix(".")

    @property
    def values(self) -> tuple[str, ...]:
        """The values of an enumeration."""
        constant = (self.schema["const"],) if "const" in self.schema else ()
        return tuple(self.schema.get("enum", constant))

    @property
    def limits(self) -> str:
        """The range, or the greatest length, in words; "" where there is none."""
        schema = self.schema
        if self.kind == "landmarks":
            return f"up to {schema['maxItems']}"
        if self.kind not in ("integer", "number"):
            return ""
        most = plain(schema["maximum"])
        if "exclusiveMinimum" in schema:
            return f"over {plain(schema['exclusiveMinimum'])}, up to {most}"
        return f"{plain(schema['minimum'])} to {most}"


def described(model: type[BaseModel]) -> tuple[Described, ...]:
    """Return the parameters of a contract, in the order in which they are shown."""
    schema = model.model_json_schema()
    found = [_described(model, name, schema["properties"][name]) for name in model.model_fields]
    return tuple(sorted(found, key=lambda one: TOPICS.index(one.topic)))


def first_sentence(text: str) -> str:
    """Return a text up to its first full stop."""
    return re.split(r"(?<=\.) ", text, maxsplit=1)[0]


def plain(number: float) -> str:
    """Return a number without needless digits."""
    if isinstance(number, int):
        return f"{number:,}" if number < 1e9 else str(number)
    return f"{number:,g}".replace("e+0", "e")


def _described(model: type[BaseModel], name: str, schema: dict[str, Any]) -> Described:
    field = model.model_fields[name]
    (topic,) = (one.name for one in field.metadata if isinstance(one, Topic))
    options = schema.get("anyOf", [schema])
    (value,) = (one for one in options if one.get("type") != "null")
    return Described(
        name=name,
        kind=_kind(value),
        nullable=len(options) > 1,
        default=field.default,
        description=schema["description"],
        topic=topic,
        schema=value,
    )


def _kind(schema: dict[str, Any]) -> str:
    if "$ref" in schema:
        return "structure"
    if "oneOf" in schema:
        return "structures"
    if schema["type"] == "array":
        return "landmarks"
    kind: str = schema["type"]
    return kind
