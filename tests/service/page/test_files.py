"""The page's files: they can be cached, are complete, and name nothing of another host."""

import re
import subprocess
import sys
from pathlib import Path, PurePosixPath

import httpx2
import pytest

from service.page import PLOTLY, STATIC, page_file
from tests.service.conftest import problem

ROOT = Path(__file__).resolve().parents[3]
FILES = sorted(path.relative_to(STATIC).as_posix() for path in STATIC.rglob("*.*"))


def test_the_page_and_its_policy(http: httpx2.Client) -> None:
    answer = http.get("/")
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    policy = dict(
        part.strip().split(" ", 1) for part in answer.headers["content-security-policy"].split(";")
    )
    assert policy["default-src"] == "'none'"
    assert policy["script-src"] == policy["style-src"] == policy["connect-src"] == "'self'"
    assert policy["frame-ancestors"] == policy["base-uri"] == "'none'"
    assert "unsafe-inline" not in str(policy)
    assert "unsafe-eval" not in str(policy)
    for link in ("/docs", "/openapi.json", "/health/ready", "/page/main.js", "/page/style.css"):
        assert f'="{link}"' in answer.text
        assert http.get(link).status_code == 200


@pytest.mark.parametrize("path", [*FILES, PLOTLY])
def test_files_are_sent_once(http: httpx2.Client, path: str) -> None:
    first = http.get(f"/page/{path}")
    assert first.status_code == 200
    assert first.headers["content-encoding"] == "gzip"
    assert first.headers["x-content-type-options"] == "nosniff"
    if path in FILES and path != "index.html":
        assert first.content == (STATIC / path).read_bytes()
    etag = first.headers["etag"]
    assert etag.startswith('W/"')
    again = http.get(f"/page/{path}", headers={"If-None-Match": etag})
    assert (again.status_code, again.content) == (304, b"")


def test_modules_are_asked_for_at_once(http: httpx2.Client) -> None:
    """All that `main.js` imports, and nothing else."""
    found, left = set(), {"main.js"}
    while left:
        found.add(path := left.pop())
        text = (STATIC / path).read_text(encoding="utf-8")
        left |= {*re.findall(r'from "\./([\w.]+)"', text)} - found
    loaded = re.findall(r'<link rel="modulepreload" href="/page/([\w.]+)">', http.get("/").text)
    assert loaded == sorted(found)


def test_only_these_files(http: httpx2.Client) -> None:
    outside = "../endpoints.py", "%2e%2e/endpoints.py", "//etc/hosts"
    for path in (*outside, "nothing.js", "", "shapes"):
        problem(http.get(f"/page/{path}"), 404, "not-found")
    assert page_file(PurePosixPath(STATIC / "main.js")) is None


@pytest.mark.parametrize("path", [path for path in FILES if path.endswith(".js")])
def test_modules_import_what_there_is(path: str) -> None:
    text = (STATIC / path).read_text(encoding="utf-8")
    for names, module in re.findall(r'import \{([^}]*)\} from "\./([\w.]+)"', text):
        exported = (STATIC / module).read_text(encoding="utf-8")
        for name in re.split(r"[,\s]+", names.strip()):
            assert re.search(rf"export (async )?(function|const|class) {name}\b", exported), name
            assert len(re.findall(rf"\b{name}\b", text)) > 1, f"{name} is not used"
    assert "innerHTML" not in text
    assert "//cdn" not in text
    assert max(map(len, text.splitlines())) <= 160


def test_plotly_js_is_found_without_importing_plotly() -> None:
    program = (
        "import sys, service.app\n"
        "from pathlib import PurePosixPath\n"
        "from service.page.files import page_file\n"
        "assert len(page_file(PurePosixPath('plotly.min.js')).packed) > 10**6\n"
        "print([name for name in sys.modules if name.split('.')[0] in ('plotly', 'numpy')])\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert said.stdout.strip() == "[]"


@pytest.mark.parametrize("there", [True, False])
def test_plotly_may_be_nothing_but_its_script(tmp_path: Path, there: bool) -> None:
    # So it is in the image of the API; without it nothing is drawn, and all else is shown.
    if there:
        (tmp_path / "plotly" / "package_data").mkdir(parents=True)
        (tmp_path / "plotly" / "__init__.py").write_text("raise ImportError")
        (tmp_path / "plotly" / "package_data" / PLOTLY).write_text("let it = 'be'")
    program = (
        "import gzip, pathlib, sys\n"
        f"sys.path[:0] = [{str(tmp_path)!r}, {str(ROOT)!r}]\n"
        f"if not {there}: sys.modules['plotly'] = None\n"
        "from service.page import page_file\n"
        f"script = page_file(pathlib.PurePosixPath({PLOTLY!r}))\n"
        "print(script and gzip.decompress(script.packed) == b\"let it = 'be'\")\n"
        "print(page_file(pathlib.PurePosixPath('main.js')) is not None)\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert said.stdout.split() == [str(there or None), "True"]
