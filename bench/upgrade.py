"""Rolling upgrades: ``python -m bench.upgrade --before REVISION``.

Starts API and workers of an earlier version, from a checkout of that revision, and replaces them by
those of this one while jobs are submitted, once with the workers first and once with the API first.
Prints what became of each job, and exits with 1 if one did not succeed, or cannot be read any more.
Both versions run with the packages that are installed here.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from bench.command_line import command_line, parsed, print_json
from bench.machines import Cluster, end, running_cluster
from demo.figures import generate, write_off
from demo.stack import ROOT

QUICK: Final[dict[str, Any]] = {"points": 12, "dense": True}
VERTICES: Final = 800


def main() -> int:
    """Upgrade in both orders, and return the exit code."""
    parser = command_line(__doc__)
    parser.add_argument("--before", required=True, metavar="REVISION", help="the earlier version")
    parser.add_argument(
        "--newer",
        type=json.loads,
        default={},
        metavar="JSON",
        help="parameters of a match that only this version knows",
    )
    options = parsed(parser)
    failed: dict[str, int] = {}
    with checkout(options.before) as before:
        for order in ("workers", "API"):
            print(f"{order} first")
            failed[f"{order}_first"] = _upgrade(before, order == "workers", options.newer)
    print_json(options, {"failed": failed})
    return 1 if any(failed.values()) else 0


@contextmanager
def checkout(revision: str) -> Iterator[Path]:
    """Check a revision out, for as long as a block of code lasts."""
    with tempfile.TemporaryDirectory(prefix="isomatch-") as folder:
        place = Path(folder, "before")
        _git("worktree", "add", "--quiet", "--detach", str(place), revision)
        try:
            yield place
        finally:
            _git("worktree", "remove", "--force", str(place))


def _git(*words: str) -> None:
    subprocess.run(["git", *words], cwd=ROOT, check=True)


def _upgrade(before: Path, workers_first: bool, newer: dict[str, Any]) -> int:
    """Upgrade once, and return the number of jobs that did not succeed."""
    figures = generate(VERTICES)
    with (
        tempfile.TemporaryDirectory(prefix="isomatch-") as folder,
        running_cluster(Path(folder), before) as cluster,
    ):
        shapes = []
        for shape in (figures.source, figures.target):
            write_off(file := Path(folder, "shape.off"), shape)
            shapes.append(cluster.upload(file.read_bytes()))
        jobs: dict[str, str] = {}

        def submit(stage: str, **more: Any) -> None:
            for name, path, body in _requests(shapes):
                given = body | more if path == "matches" else body
                answer = cluster.http.post(f"/v1/{path}", json=given)
                if answer.status_code != 202:
                    print(f"  {stage:28} {name:10} refused: {answer.json().get('detail')}")
                    continue
                jobs[f"{stage:28} {name}"] = answer.json()["id"]

        submit("earlier version")
        steps: list[Callable[[Cluster], None]] = [_new_workers, _new_api]
        for step in steps if workers_first else reversed(steps):
            step(cluster)
            submit(f"after {step.__name__.removeprefix('_').replace('_', ' ')}")
            if not workers_first and step is _new_api and newer:
                submit("newer parameters", **newer)
        return sum(not _told(cluster, name, job) for name, job in jobs.items())


def _requests(shapes: list[str]) -> list[tuple[str, str, dict[str, Any]]]:
    source, target = shapes
    return [
        ("match", "matches", {"source": source, "target": target, **QUICK}),
        ("batch", "batches", {"source": source, "targets": [target], **QUICK}),
        ("compare", "dissimilarities", {"shapes": shapes}),
    ]


def _new_workers(cluster: Cluster) -> None:
    """Replace the workers, as an orchestrator does: a new one, then the end of an old one."""
    cluster.root = ROOT
    for old in list(cluster.workers):
        cluster.workers.append(cluster.start_worker())
        old.terminate()
        old.wait()
        cluster.workers.remove(old)
    cluster.until(lambda: cluster.ready() >= 1, 240)


def _new_api(cluster: Cluster) -> None:
    cluster.root = ROOT
    end(cluster.api)
    cluster.api = cluster.start_api()


def _told(cluster: Cluster, name: str, job: str) -> bool:
    """Say what became of a job; False if it did not succeed."""
    record = cluster.ended(job)
    result = cluster.http.get(f"/v1/jobs/{job}/result")
    error = record["error"] or {}
    print(f"  {name:39} {record['state']:10} {error.get('detail', '')}")
    return bool(record["state"] == "succeeded" and result.status_code == 200)


if __name__ == "__main__":
    sys.exit(main())
