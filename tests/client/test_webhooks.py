"""What a receiver of webhooks believes."""

import hashlib
import hmac
import json
import re
import time
from collections.abc import Callable
from pathlib import Path

import isomatch
import pytest
from isomatch import verify_webhook

SECRET = "sixteen letters or more"
BODY = json.dumps(
    {
        "type": "job.ended",
        "job": {
            "id": "1",
            "kind": "match",
            "state": "succeeded",
            "created": "2026-01-01T00:00:00Z",
            "started": None,
            "ended": None,
            "error": None,
            "path": "/v1/jobs/1",
        },
    }
).encode()


def signature(body: bytes = BODY, secret: str = SECRET, age: float = 0.0) -> str:
    when = int(time.time() - age)
    digest = hmac.new(secret.encode(), f"{when}.".encode() + body, hashlib.sha256).hexdigest()
    return f"t={when},v1={digest}"


def test_valid_signatures() -> None:
    event = verify_webhook(BODY, signature(), SECRET)
    assert (event.type, event.job.id, event.job.state) == ("job.ended", "1", "succeeded")
    assert verify_webhook(BODY, signature(age=200), SECRET) == event
    assert verify_webhook(BODY, signature(age=500), SECRET, tolerance=600) == event


# A signature carries the time: it is made when its test runs, for names of tests may not change.
@pytest.mark.parametrize(
    ("body", "stated", "message"),
    [
        pytest.param(BODY + b" ", signature, "not signed with", id="another body"),
        pytest.param(
            BODY,
            lambda: signature(secret="another secret, as long"),
            "not signed with",
            id="another secret",
        ),
        pytest.param(BODY, lambda: None, "not signed with", id="none"),
        pytest.param(BODY, lambda: "", "not signed with", id="empty"),
        pytest.param(BODY, lambda: "t=1", "not signed with", id="only a time"),
        pytest.param(BODY, lambda: "v1=\xe4", "not signed with", id="not ASCII"),
        pytest.param(
            BODY, lambda: signature().replace("t=", "t=1"), "not signed with", id="another time"
        ),
        pytest.param(BODY, lambda: signature(age=4000), "within 300 s", id="too old"),
        pytest.param(BODY, lambda: signature(age=-4000), "within 300 s", id="of the future"),
        pytest.param(b"{}", lambda: signature(b"{}"), "not about a job", id="not an event"),
    ],
)
def test_invalid_signatures(body: bytes, stated: Callable[[], str | None], message: str) -> None:
    with pytest.raises(isomatch.InvalidSignature, match=message):
        verify_webhook(body, stated(), SECRET)


def test_the_example_of_the_guide() -> None:
    guide = (Path(__file__).resolve().parents[2] / "docs" / "api.md").read_text(encoding="utf-8")
    named = dict(re.findall(r"(?m)^\| (secret|TIME|body|HEX) \| `(.+)` \|$", guide))
    signed = f"{named['TIME']}.{named['body']}".encode()
    digest = hmac.new(named["secret"].encode(), signed, hashlib.sha256).hexdigest()
    assert digest == named["HEX"]
    # To the SDK it is right, but old.
    stated = f"t={named['TIME']},v1={named['HEX']}"
    with pytest.raises(isomatch.InvalidSignature, match="within"):
        verify_webhook(named["body"].encode(), stated, named["secret"])
