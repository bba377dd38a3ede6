"""Types of the keyword arguments of jobs: choices, and landmarks as lists or arrays."""

import json
from typing import Any, Literal, get_type_hints

import isomatch
import pytest

from codegen.described import JOBS, Job, described
from service.http.openapi.examples import EXAMPLES

EXAMPLE: dict[str, Any] = EXAMPLES["answers"]["get_result"]["200"]["match"]


@pytest.mark.parametrize("job", JOBS, ids=lambda job: job.name)
def test_choices_are_those_of_the_service(job: Job) -> None:
    hints = get_type_hints(getattr(isomatch, job.model.__name__))
    for one in described(job.model):
        if one.kind == "string":
            choice: Any = Literal.__getitem__(one.values)
            assert hints[one.name] == (choice | None if one.nullable else choice)


def test_results_may_have_choices_of_other_versions() -> None:
    parameters = {**EXAMPLE["parameters"], "geodesic_method": "exact", "landmarks": [[17, 203]]}
    match = isomatch.Match.from_json(json.dumps({**EXAMPLE, "parameters": parameters}))
    assert dict(match.parameters) == {**parameters, "landmarks": [(17, 203)]}
