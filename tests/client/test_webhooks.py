"""What a receiver of webhooks believes."""

import hashlib
import hmac
import json
import time

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


def test_what_is_signed_is_believed() -> None:
    event = verify_webhook(BODY, signature(), SECRET)
    assert (event.type, event.job.id, event.job.state) == ("job.ended", "1", "succeeded")
    assert verify_webhook(BODY, signature(age=200), SECRET) == event
    assert verify_webhook(BODY, signature(age=500), SECRET, tolerance=600) == event


@pytest.mark.parametrize(
    ("body", "stated", "message"),
    [
        (BODY + b" ", signature(), "not signed with"),
        (BODY, signature(secret="another secret, as long"), "not signed with"),
        (BODY, None, "not signed with"),
        (BODY, "", "not signed with"),
        (BODY, "t=1", "not signed with"),
        (BODY, "v1=\xe4", "not signed with"),
        (BODY, signature().replace("t=", "t=1"), "not signed with"),
        (BODY, signature(age=4000), "within 300 s"),
        (BODY, signature(age=-4000), "within 300 s"),
        (b"{}", signature(b"{}"), "no job"),
    ],
)
def test_what_is_not_is_not(body: bytes, stated: str | None, message: str) -> None:
    with pytest.raises(isomatch.InvalidSignature, match=message):
        verify_webhook(body, stated, SECRET)
