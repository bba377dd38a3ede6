"""Settings from the environment."""

from broker.environment import misspelt_variables
from service.settings import Settings
from worker.settings import WorkerSettings


def test_misspelt_variables_are_named() -> None:
    given = ["ISOMATCH_WORKER", "ISOMATCH_MAX_UPLOAD_BYTE", "ISOMATCH_PORT", "PATH", "ISOMATCH_"]
    assert misspelt_variables(given, Settings) == {
        "ISOMATCH_WORKER": "ISOMATCH_WORKERS",
        "ISOMATCH_MAX_UPLOAD_BYTE": "ISOMATCH_MAX_UPLOAD_BYTES",
    }


def test_variables_of_others_are_none() -> None:
    others = [f"ISOMATCH_{name}".upper() for name in WorkerSettings.model_fields]
    others += ["ISOMATCH_URL", "ISOMATCH_API_KEY", "ISOMATCH_DATA"]
    assert misspelt_variables(others, Settings) == {}
