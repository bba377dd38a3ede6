"""The asynchronous and the blocking client have one surface, documented in the source of both."""

import ast
import inspect
import re
import sys

import isomatch
import pytest

PAIRS: list[tuple[type, type]] = [
    (isomatch.AsyncClient, isomatch.Client),
    (isomatch.AsyncJob, isomatch.Job),
    (isomatch.AsyncLandmarkJob, isomatch.LandmarkJob),
]

Method = ast.FunctionDef | ast.AsyncFunctionDef


def source(kind: type) -> ast.ClassDef:
    (defined,) = ast.parse(inspect.getsource(kind)).body
    assert isinstance(defined, ast.ClassDef)
    return defined


def public(kind: type) -> dict[str, Method]:
    """The methods that a class defines itself, as an editor reads them."""
    methods = (one for one in source(kind).body if isinstance(one, Method))
    return {one.name: one for one in methods if not one.name.startswith("_")}


@pytest.mark.parametrize(("later", "blocking"), PAIRS)
def test_methods_have_docstrings_and_the_same_parameters(later: type, blocking: type) -> None:
    twins = public(blocking)
    assert len(twins) > 1
    assert list(twins) == list(public(later))
    for name, method in public(later).items():
        assert ast.get_docstring(method), name
        assert ast.get_docstring(twins[name]), name
        assert ast.unparse(method.args) == ast.unparse(twins[name].args), name


@pytest.mark.parametrize("kind", [blocking for _, blocking in PAIRS])
def test_the_blocking_client_awaits_nothing_and_names_no_tasks(kind: type) -> None:
    assert not re.search(r"(?i)async|await|\btasks?\b", inspect.getsource(kind))


@pytest.mark.parametrize("kind", [blocking for _, blocking in PAIRS])
def test_types_of_methods_can_be_imported_to_annotate_with(kind: type) -> None:
    module = ast.parse(inspect.getsource(sys.modules[kind.__module__]))
    ours = {
        alias.name
        for one in module.body
        if isinstance(one, ast.ImportFrom) and str(one.module).startswith("isomatch")
        for alias in one.names
    }
    for name, method in public(kind).items():
        parts = [*ast.walk(method.args), *ast.walk(method.returns or ast.Pass())]
        used = {one.id for one in parts if isinstance(one, ast.Name)} & ours
        # The base of all jobs, and the value of a default.
        assert used - {"RecordedJob", "UPLOAD_TIMEOUT"} <= set(isomatch.__all__), name
