"""The manifests for Kubernetes: confined pods, honest probes, no busy worker that is stopped."""

import re
import subprocess
from pathlib import Path
from shutil import which
from typing import Any

import kubernetes_validate
import pytest
import yaml

from broker.queue import QueueSettings
from broker.queue.settings import JOBS
from service.app import create_app
from service.settings import Settings
from tests.containers.manifests import (
    KUBERNETES,
    OBJECT_STORAGE,
    Pod,
    objects,
    pods,
    secret,
    settings_names,
)
from worker.settings import WorkerSettings

OURS = ("isomatch-api", "isomatch-worker")
PODS = {pod.name: pod for pod in pods()}


def of_kind(kind: str) -> list[dict[str, Any]]:
    return [each for each in objects() if each["kind"] == kind]


def chosen_by(labels: dict[str, str]) -> list[Pod]:
    return [pod for pod in PODS.values() if labels.items() <= pod.labels.items()]


def test_there_is_something_to_look_at() -> None:
    assert set(PODS) == {*OURS, "isomatch-burst", "isomatch-queue", "isomatch-cache"}


@pytest.mark.parametrize("pod", PODS.values(), ids=PODS)
def test_pods_are_confined(pod: Pod) -> None:
    whole, container = pod.spec["securityContext"], pod.container["securityContext"]
    assert whole["runAsNonRoot"] is True
    assert whole["runAsUser"] == (10001 if "isomatch-" in pod.container["image"] else 999)
    assert whole["seccompProfile"] == {"type": "RuntimeDefault"}
    assert container == {
        "allowPrivilegeEscalation": False,
        "readOnlyRootFilesystem": True,
        "capabilities": {"drop": ["ALL"]},
    }
    assert pod.spec["automountServiceAccountToken"] is False
    # Kubernetes would set ISOMATCH_..._PORT and the like for each of the services.
    assert pod.spec["enableServiceLinks"] is False
    assert "memory" in pod.container["resources"]["limits"]
    volumes = {each["name"] for each in pod.spec.get("volumes", ())}
    volumes |= {
        each["metadata"]["name"] for each in pod.owner["spec"].get("volumeClaimTemplates", ())
    }
    assert {mount["name"] for mount in pod.container["volumeMounts"]} == volumes


@pytest.mark.parametrize("pod", PODS.values(), ids=PODS)
def test_probes_ask_what_is_there(pod: Pod) -> None:
    paths = create_app(Settings(redis_url="redis://nowhere", blob_url="s3://nowhere")).openapi()[
        "paths"
    ]
    probes = {name: probe for name, probe in pod.container.items() if name.endswith("Probe")}
    if pod.name == "isomatch-burst":
        assert not probes, "a job ends by itself"
        return
    assert {"startupProbe", "livenessProbe"} <= set(probes)
    for probe in probes.values():
        if "httpGet" in probe:
            assert "get" in paths[probe["httpGet"]["path"]]
            (port,) = pod.container["ports"]
            assert probe["httpGet"]["port"] == port["name"]
        elif "exec" in probe:
            assert probe["exec"]["command"] in (
                ["python", "-m", "worker.process.health"],
                ["valkey-cli", "-e", "ping"],
            )


def test_no_state_that_all_pods_share_takes_them_out_of_the_service() -> None:
    probes = [probe for name, probe in PODS["isomatch-api"].container.items() if "Probe" in name]
    assert {probe["httpGet"]["path"] for probe in probes} == {"/health/live"}


def test_settings_have_the_names_that_are_read() -> None:
    read = settings_names(Settings, WorkerSettings) | {"REDIS_PASSWORD", *OBJECT_STORAGE}
    for name in (*OURS, "isomatch-burst"):
        found = set(PODS[name].environment())
        assert found <= read
        assert {"ISOMATCH_REDIS_URL", "ISOMATCH_CACHE_URL", "ISOMATCH_BLOB_URL"} <= found
        # What a pod sets itself cannot be changed in the ConfigMap or the secret.
        fixed = {variable["name"] for variable in PODS[name].container.get("env", ())}
        assert fixed <= {"ISOMATCH_AUTH", "ISOMATCH_DRAIN_SECONDS"}


def test_secrets_are_named_and_not_told() -> None:
    assert not of_kind("Secret")
    named = re.findall(r"key: (\S+?)\}", "".join(f.read_text() for f in KUBERNETES.rglob("*.yaml")))
    # The password of both stores, for each of them and for KEDA.
    assert named == ["REDIS_PASSWORD"] * 3
    assert "REDIS_PASSWORD" in secret()


def test_keys_of_callers_are_given_to_the_api_alone() -> None:
    given = {
        name: {
            source["secretRef"]["name"]
            for source in pod.container["envFrom"]
            if "secretRef" in source
        }
        for name, pod in PODS.items()
        if name in (*OURS, "isomatch-burst")
    }
    api = given.pop("isomatch-api")
    assert api == {"isomatch", "isomatch-api"}
    assert set(map(frozenset, given.values())) == {frozenset({"isomatch"})}


def test_addresses_are_those_of_services() -> None:
    services = {each["metadata"]["name"]: each["spec"] for each in of_kind("Service")}
    for name in ("ISOMATCH_REDIS_URL", "ISOMATCH_CACHE_URL"):
        host, port = secret()[name].split("@")[1].split("/")[0].split(":")
        assert services[host]["ports"][0]["port"] == int(port)
    for service in services.values():
        (chosen,) = [
            pod for pod in PODS.values() if service["selector"].items() <= pod.labels.items()
        ]
        assert service["ports"][0]["targetPort"] == chosen.container["ports"][0]["name"]


def test_selectors_choose_pods() -> None:
    for each in objects():
        selector = each["spec"].get("selector") if "spec" in each else None
        if isinstance(selector, dict) and "matchLabels" in selector:
            assert any(
                selector["matchLabels"].items() <= pod.labels.items() for pod in PODS.values()
            )
    for policy in of_kind("NetworkPolicy"):
        for rule in policy["spec"]["podSelector"].get("matchExpressions", ()):
            for value in rule["values"]:
                assert any(pod.labels[rule["key"]] == value for pod in PODS.values())


@pytest.mark.parametrize("pod", PODS.values(), ids=PODS)
def test_pods_reach_what_they_need_and_nothing_else(pod: Pod) -> None:
    policies = [each["spec"] for each in of_kind("NetworkPolicy") if chooses(each["spec"], pod)]
    # Kubernetes confines only those directions that some policy of a pod names.
    assert {"Ingress", "Egress"} <= {kind for each in policies for kind in each["policyTypes"]}
    rules = [rule for each in policies for rule in each.get("egress", ())]
    assert all(rule.get("to") and rule.get("ports") for rule in rules)
    ports = {port["port"] for rule in rules for port in rule["ports"]}
    needed = {6379, 53, 443, 80}
    assert ports == (set() if pod.name in ("isomatch-queue", "isomatch-cache") else needed)


def chooses(policy: dict[str, Any], pod: Pod) -> bool:
    selector = policy["podSelector"]
    return selector.get("matchLabels", {}).items() <= pod.labels.items() and all(
        pod.labels[rule["key"]] in rule["values"] for rule in selector.get("matchExpressions", ())
    )


def test_an_api_that_stops_has_time_for_its_uploads() -> None:
    pod = PODS["isomatch-api"]
    (drain,) = [e["value"] for e in pod.container["env"] if e["name"] == "ISOMATCH_DRAIN_SECONDS"]
    (_, pause) = pod.container["lifecycle"]["preStop"]["exec"]["command"]
    assert int(pause) + int(drain) < pod.spec["terminationGracePeriodSeconds"]


def test_no_busy_worker_is_stopped() -> None:
    (settings,) = of_kind("ConfigMap")
    longest = int(settings["data"]["ISOMATCH_JOB_TIMEOUT"])
    assert longest == QueueSettings().job_timeout
    for name in ("isomatch-worker", "isomatch-burst"):
        assert PODS[name].spec["terminationGracePeriodSeconds"] > longest
    memory = int(settings["data"]["ISOMATCH_JOB_MEMORY_MB"])
    for name in ("isomatch-worker", "isomatch-burst"):
        limit = PODS[name].container["resources"]["limits"]["memory"]
        assert memory <= 0.75 * int(limit.removesuffix("Gi")) * 1024
    burst = PODS["isomatch-burst"]
    # It leaves when there is nothing to do, and after some jobs in any case.
    assert burst.container["args"][:2] == ["--burst", "--jobs"]
    assert burst.spec["restartPolicy"] == "Never"
    assert burst.owner["spec"]["rollout"] == {"strategy": "gradual"}
    scaled = [each["spec"]["scaleTargetRef"]["name"] for each in of_kind("HorizontalPodAutoscaler")]
    assert scaled == ["isomatch-api"]
    assert not of_kind("ScaledObject")


def test_the_scaling_looks_at_the_queue() -> None:
    (scaled,) = of_kind("ScaledJob")
    length, age = scaled["spec"]["triggers"]
    assert length["metadata"]["listName"] == f"rq:queue:{JOBS}"
    (password,) = of_kind("TriggerAuthentication")
    assert length["authenticationRef"]["name"] == password["metadata"]["name"]
    services = {each["metadata"]["name"]: each for each in of_kind("Service")}
    assert [port["port"] for port in services["isomatch-api"]["spec"]["ports"]] == [80]
    assert age["metadata"]["url"] == "http://isomatch-api.isomatch.svc/metrics"
    assert age["metadata"]["valueLocation"] == "isomatch_queue_age_seconds"
    assert scaled["spec"]["scalingStrategy"]["multipleScalersCalculation"] == "max"
    # There is no schema of KEDA's own objects here; the job that it makes of this is Kubernetes'.
    job = {
        "apiVersion": "batch/v1",
        "kind": "Job",
        "metadata": {"name": "burst"},
        "spec": scaled["spec"]["jobTargetRef"],
    }
    kubernetes_validate.validate(job, "1.37", strict=True)


def test_kustomizations_name_all_files() -> None:
    for file in KUBERNETES.rglob("kustomization.yaml"):
        kustomization = yaml.safe_load(file.read_text())
        beside = {each.name for each in file.parent.glob("*.yaml")} - {file.name}
        assert set(kustomization["resources"]) == beside
        text = "".join((file.parent / each).read_text() for each in beside)
        run = {name for name in OURS if f"image: {name}\n" in text}
        assert {image["name"] for image in kustomization["images"]} == run
        # Nodes would keep an old image of a tag that moves; one that is not set is nowhere.
        assert {image["newTag"] for image in kustomization["images"]} == {"name-the-version"}


@pytest.mark.skipif(which("kubectl") is None, reason="needs kubectl")
@pytest.mark.parametrize("folder", [KUBERNETES, KUBERNETES / "autoscaling"], ids=lambda it: it.name)
def test_kustomizations_can_be_built(folder: Path) -> None:
    command = ["kubectl", "kustomize", str(folder)]
    built = subprocess.run(command, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    assert all(each["kind"] for each in yaml.safe_load_all(built.stdout))
