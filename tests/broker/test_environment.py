"""Settings from the environment."""

import pytest
from pydantic import ValidationError

from broker.environment import misspelt_variables, setting_errors
from service.settings import Settings
from worker.settings import WorkerSettings


def test_misspelt_variables_are_named() -> None:
    given = ["ISOMATCH_WORKER", "ISOMATCH_MAX_UPLOAD_BYTE", "ISOMATCH_PORT", "PATH", "ISOMATCH_"]
    assert misspelt_variables(given, Settings) == {
        "ISOMATCH_WORKER": "ISOMATCH_WORKERS",
        "ISOMATCH_MAX_UPLOAD_BYTE": "ISOMATCH_MAX_UPLOAD_BYTES",
    }


@pytest.mark.parametrize("url", ["redis://:se/cret@queue:6379/0", "redis://:s#e@q:1", "http://x"])
def test_an_address_that_is_none_is_refused_and_not_quoted(url: str) -> None:
    with pytest.raises(ValidationError) as refused:
        WorkerSettings(redis_url=url)
    (line,) = setting_errors(refused.value)
    assert line.startswith("ISOMATCH_REDIS_URL: not an address of a Redis")
    assert "percent-encoded" in line
    assert "'" not in line


@pytest.mark.parametrize("settings", [Settings, WorkerSettings])
def test_variables_of_others_are_none(settings: type[Settings] | type[WorkerSettings]) -> None:
    names = {*Settings.model_fields, *WorkerSettings.model_fields}
    others = [f"ISOMATCH_{name}".upper() for name in names]
    others += ["ISOMATCH_URL", "ISOMATCH_API_KEY", "ISOMATCH_DATA"]
    assert misspelt_variables(others, settings) == {}
