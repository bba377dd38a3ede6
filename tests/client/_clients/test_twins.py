"""The sync and the async client have one surface."""

import inspect
import re
from collections.abc import Callable
from typing import Any

import isomatch
import pytest

PAIRS: list[tuple[type, type]] = [
    (isomatch.Client, isomatch.AsyncClient),
    (isomatch.Job, isomatch.AsyncJob),
    (isomatch.LandmarkJob, isomatch.AsyncLandmarkJob),
]
LATER = [(r"\bAsync(Client|Job|LandmarkJob)\b", r"\1"), (r"\bAsync(Iterator|Generator)\b", r"\1")]
BLOCKING = {
    "base_url",
    "__init__",
    "__repr__",
    "shapes",
    "prototypes",
    "jobs",
    "events",
    "ended_matches",
}
"""What an async client does without being awaited."""


def public(kind: type) -> dict[str, Any]:
    return {
        name: value
        for name, value in inspect.getmembers(kind)
        if not name.startswith("_") or name == "__init__"
    }


def blocking(text: object) -> str:
    """An annotation of the async client as the sync one has it."""
    plain = text if isinstance(text, str) else inspect.formatannotation(text)
    for pattern, replacement in LATER:
        plain = re.sub(pattern, replacement, plain)
    return re.sub(
        r"isomatch\._clients\.async_(client|job|landmark_job)\.", r"isomatch._clients.\1.", plain
    )


def form(method: Callable[..., Any]) -> list[tuple[object, ...]]:
    signature = inspect.signature(method)
    parameters = [
        (given.name, given.kind, given.default, blocking(given.annotation))
        for given in signature.parameters.values()
        if given.name != "transport"
    ]
    return [*parameters, ("return", blocking(signature.return_annotation))]


@pytest.mark.parametrize(("sync", "later"), PAIRS)
def test_names_signatures_and_documentation_are_the_same(sync: type, later: type) -> None:
    ours, theirs = public(sync), public(later)
    assert set(ours) == set(theirs)
    assert len(ours) > 2
    for name, value in ours.items():
        twin = theirs[name]
        if name != "__init__" and callable(value):
            assert inspect.getdoc(value), name
            assert inspect.getdoc(value) == inspect.getdoc(twin), name
            assert inspect.iscoroutinefunction(twin) == (name not in BLOCKING), name
        if callable(value):
            assert form(value) == form(twin), name
        elif isinstance(value, property):
            assert value is twin, name
