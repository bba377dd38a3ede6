"""Exit codes and messages of refusals, by the options of the running command."""

import json
from collections.abc import Sequence

import httpx2
import isomatch
import pytest
from isomatch import cli
from isomatch._cli import exit_codes
from isomatch._cli.job_runs import cancelled_by_interrupt, job_continues
from isomatch._clients import Client
from isomatch._models import JobRecord
from typer import Exit
from typer.testing import CliRunner

from tests.client._http.test_connection import JOB

ID = 32 * "0"


@pytest.mark.parametrize(
    ("command", "field", "option"),
    [
        (["prototype", "list"], "query.name", "--name"),
        (["jobs", "list"], "query.state", "--state"),
        (["jobs", "list"], "body.points", None),
        (["match", ID, ID], "body.points", "--points"),
        (["match", ID, ID], "body.landmarks.0.1", "--landmark (0.1)"),
        (["match", ID, ID], "body.source", None),
        (["transfer", ID, "--what", "skinning"], "body.influences", "--influences"),
        (["transfer", ID, "--what", "scalars"], "body.on", "--on"),
        (["transfer", ID, "--what", "scalars"], "body.names.0", "--name (0)"),
        (["compare", ID, ID], "body.labels", "--labels"),
        (["register", ID, ID, "--no-wait"], "body.scale", "--scale"),
        (["prototype", "learn", ID, ID], "body.correspondence", None),
        (["prototype", "learn", ID, ID], "body.name", "--name"),
    ],
)
def test_refused_options_are_wrong_usage(
    monkeypatch: pytest.MonkeyPatch, command: Sequence[str], field: str, option: str | None
) -> None:
    problem = {
        "type": "urn:isomatch:problem:invalid-request",
        "title": "Invalid request",
        "status": 422,
        "errors": [{"field": field, "message": "is refused"}],
    }
    headers = {"content-type": "application/problem+json"}
    refusal = httpx2.MockTransport(lambda _: httpx2.Response(422, json=problem, headers=headers))
    monkeypatch.setattr(exit_codes, "Client", lambda url: Client(url, transport=refusal))
    done = CliRunner().invoke(cli.app, command)
    assert done.exit_code == (1 if option is None else 2)
    assert f": {option or field.removeprefix('body.')}: is refused" in done.stderr


@pytest.mark.parametrize("as_json", [False, True])
def test_an_outage_names_the_command_for_the_result(
    capsys: pytest.CaptureFixture[str], as_json: bool
) -> None:
    error = isomatch.ConnectionFailed("gone")
    error.job_id = ID
    with pytest.raises(Exit) as left:
        exit_codes.leave(error, as_json)
    assert left.value.exit_code == 3
    said = capsys.readouterr().err
    message = json.loads(said)["detail"] if as_json else said
    assert f"gone; get its result with `isomatch jobs result {ID}`" in message


def test_a_failed_job_has_no_result_to_get(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(Exit):
        exit_codes.leave(isomatch.JobCancelled(ID))
    assert capsys.readouterr().err == f"isomatch: job {ID} was cancelled\n"


@pytest.mark.parametrize(("status", "code"), [(413, 1), (503, 1), (502, 3), (504, 3)])
def test_a_proxy_that_refuses_is_no_missing_service(
    monkeypatch: pytest.MonkeyPatch, status: int, code: int
) -> None:
    answer = httpx2.Response(status, html="<p>No", headers={"retry-after": "90"})
    proxy = httpx2.MockTransport(lambda _: answer)
    monkeypatch.setattr(exit_codes, "Client", lambda url: Client(url, transport=proxy))
    done = CliRunner().invoke(cli.app, ["shapes"])
    assert done.exit_code == code
    assert f"perhaps by a proxy: {status}" in done.stderr


def interrupted(capsys: pytest.CaptureFixture[str], as_json: bool, continues: bool) -> str:
    """What a command prints on Ctrl-C while its job runs."""
    record = JobRecord.model_validate(JOB | {"state": "cancelled"})
    answer = httpx2.Response(200, text=record.model_dump_json())
    client = isomatch.Client("http://a.test", transport=httpx2.MockTransport(lambda _: answer))
    job = isomatch.Job(client._transport, JobRecord.model_validate(JOB | {"state": "running"}))
    watched = (
        job_continues(job) if continues else cancelled_by_interrupt(lambda: job, None, as_json)
    )
    command = exit_codes.connected("http://a.test", as_json)
    with client, pytest.raises(Exit) as left, command, watched:
        raise KeyboardInterrupt
    assert left.value.exit_code == 130
    return capsys.readouterr().err


@pytest.mark.parametrize("continues", [False, True])
def test_an_interrupt_says_what_became_of_the_job(
    capsys: pytest.CaptureFixture[str], continues: bool
) -> None:
    became = f"job {ID} continues; cancel it with" if continues else f"job {ID} cancelled"
    first, second = interrupted(capsys, as_json=False, continues=continues).splitlines()
    assert first.startswith(became)
    assert second == "interrupted"
    document = json.loads(interrupted(capsys, as_json=True, continues=continues))
    assert document["type"] == "urn:isomatch:client:interrupted"
    assert document["detail"].startswith(became)
