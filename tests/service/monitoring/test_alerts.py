"""The alerts that are shipped: about what is exported, and explained in the guide."""

import re
import shutil
import subprocess
from typing import Any

import httpx2
import pytest
import yaml

from broker.contracts import JobKind
from service.standalone import EmbeddedServer
from tests.containers.manifests import DOCKER, ROOT
from tests.service.conftest import idle_api

RULES = DOCKER / "prometheus" / "rules.yaml"


def alerts() -> list[dict[str, Any]]:
    (group,) = yaml.safe_load(RULES.read_text())["groups"]
    found: list[dict[str, Any]] = group["rules"]
    return found


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The metrics of a service whose Redis has a limit, and that has run one job."""
    server = EmbeddedServer(tmp_path_factory.mktemp("redis"))
    server.start()
    try:
        with idle_api(server) as api:
            api.store.client.config_set("maxmemory", 2**30)
            api.store.counters.observe(JobKind.VALIDATION, {"in the queue": 1.0})
            return httpx2.get(f"{api.url}/metrics", timeout=60.0).text
    finally:
        server.stop()


@pytest.mark.parametrize("alert", alerts(), ids=lambda alert: alert["alert"])
def test_alerts_are_about_what_is_exported(alert: dict[str, Any], exported: str) -> None:
    selected = re.findall(r"(isomatch_\w+)(?:\{(.*?)\})?", alert["expr"])
    assert selected
    for metric, labels in selected:
        series = [line for line in exported.splitlines() if re.match(rf"{metric}\b", line)]
        assert series, metric
        for label, values in re.findall(r'(\w+)=~?"([^"]*)"', labels):
            for value in values.split("|"):
                # Also before anything has failed: `rate` needs a first 0.
                assert any(f'{label}="{value}"' in line for line in series), (label, value)


def test_the_guide_explains_every_alert() -> None:
    guide = (ROOT / "docs" / "operations.md").read_text()
    explained = re.findall(r"(?m)^\| `(Isomatch\w+)` \|", guide)
    assert explained == [alert["alert"] for alert in alerts()]


@pytest.mark.skipif(shutil.which("promtool") is None, reason="needs promtool")
def test_prometheus_reads_the_rules() -> None:
    command = ["promtool", "check", "rules", str(RULES)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
