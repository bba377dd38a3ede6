"""What is in ``docker/``, read as the tools that use it read it."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from service.settings import Settings
from worker.settings import WorkerSettings

ROOT = Path(__file__).resolve().parents[2]
DOCKER = ROOT / "docker"
KUBERNETES = DOCKER / "kubernetes"
COMPOSE = DOCKER / "compose.yaml"

Json = dict[str, Any]


OBJECT_STORAGE = (
    "AWS_ENDPOINT_URL",
    "AWS_REGION",
    "AWS_ACCESS_KEY_ID",
    "AWS_SECRET_ACCESS_KEY",
    "AWS_SESSION_TOKEN",
)
"""Variables that the library of object storage reads itself."""


def settings_names(*classes: type[Settings] | type[WorkerSettings]) -> set[str]:
    """Names of the environment variables that settings are read from."""
    return {f"ISOMATCH_{name.upper()}" for each in classes for name in each.model_fields}


def compose(file: Path = COMPOSE) -> Json:
    """The compose file, with its anchors."""
    read: Json = yaml.safe_load(file.read_text())
    return read


def stages() -> dict[str, list[tuple[str, str]]]:
    """Instructions of each stage of the Dockerfile, continuation lines joined."""
    found: dict[str, list[tuple[str, str]]] = {}
    lines = [
        line
        for line in (DOCKER / "Dockerfile").read_text().splitlines()
        if line.strip() and not line.lstrip().startswith("#")
    ]
    for line in "\n".join(lines).replace("\\\n", " ").splitlines():
        word, _, rest = line.strip().partition(" ")
        if word == "FROM":
            name = rest.split(" AS ")[1]
            found[name] = []
        found[name].append((word, " ".join(rest.split())))
    return found


def objects() -> list[Json]:
    """All objects of the Kubernetes manifests, kustomizations apart."""
    return [
        document
        for file in sorted(KUBERNETES.rglob("*.yaml"))
        if file.name != "kustomization.yaml"
        for document in yaml.safe_load_all(file.read_text())
    ]


def secret() -> dict[str, str]:
    """Keys and values of the secret `isomatch`, as the operations guide has one create it."""
    guide = (ROOT / "docs" / "operations.md").read_text()
    return dict(re.findall(r"--from-literal=(\S+?)=(\S+)", guide))


@dataclass(frozen=True)
class Pod:
    """A template of pods.

    Attributes
    ----------
    owner
        What makes pods of it.
    labels
        What its pods are chosen by.
    spec
        The pod.
    """

    owner: Json
    labels: dict[str, str]
    spec: Json

    @property
    def name(self) -> str:
        """Name of the owner."""
        name: str = self.owner["metadata"]["name"]
        return name

    @property
    def container(self) -> Json:
        """Its only container."""
        (container,) = self.spec["containers"]
        found: Json = container
        return found

    def environment(self) -> Iterator[str]:
        """Names of the variables that its container is given."""
        for variable in self.container.get("env", ()):
            yield variable["name"]
        for source in self.container.get("envFrom", ()):
            if "secretRef" in source:
                # The secret of the API may be missing.
                if not source["secretRef"].get("optional"):
                    assert source["secretRef"]["name"] == "isomatch"
                    yield from secret()
                continue
            (settings,) = [
                each
                for each in objects()
                if each["kind"] == "ConfigMap"
                and each["metadata"]["name"] == source["configMapRef"]["name"]
            ]
            yield from settings["data"]


def pods() -> list[Pod]:
    """All templates of pods."""
    found = []
    for each in objects():
        spec = each.get("spec", {})
        template = spec.get("template") or spec.get("jobTargetRef", {}).get("template")
        if template is not None:
            found.append(Pod(each, template["metadata"]["labels"], template["spec"]))
    return found
