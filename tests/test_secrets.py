"""A whole run against an endpoint that gives the key back wherever it can: it stands in no file, and in nothing that is shown."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import ClassVar

import pytest

#: It does not look like a credential: no pattern would find it.
KEY = "Zaunkoenig" + "Sommerwiese"


class Echo(BaseHTTPRequestHandler):
    """Answers each request in another way, always with the key in it."""

    ways: ClassVar[list[int]] = []
    heard: ClassVar[list[str]] = []

    def do_POST(self) -> None:
        length = int(self.headers.get("content-length", 0))
        prompt = self.rfile.read(length).decode()
        authorization = self.headers.get("authorization", "")
        type(self).heard.append(authorization)
        assert KEY not in prompt
        way = len(type(self).ways)
        type(self).ways.append(way)
        error = {"error": {"message": f"wrong key {authorization} for {KEY}", "type": KEY, "code": KEY}}
        reply = {
            "choice": "description",
            "confidence": 0.9,
            "forecast": "none",
            "forecast_probability": 0.6,
            "because": [f"the key is {KEY}", authorization],
        }
        content = [json.dumps(reply), f"no JSON but {KEY}", json.dumps({**reply, "choice": KEY})][way % 3]
        message = {"role": "assistant", "content": content}
        completion = {"id": KEY, "object": "chat.completion", "created": 0, "model": KEY, "usage": None}
        good = {**completion, "choices": [{"index": 0, "finish_reason": "stop", "message": message}]}
        status, body = [(200, good), (401, error), (500, error), (429, error), (200, good), (200, {"odd": KEY})][way % 6]
        text = json.dumps(body).encode()
        self.send_response(status, f"status with {KEY}")
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(text)))
        self.send_header("x-request-id", KEY)
        self.end_headers()
        self.wfile.write(text)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@pytest.fixture
def endpoint() -> Iterator[str]:
    Echo.ways.clear()
    Echo.heard.clear()
    server = ThreadingHTTPServer(("127.0.0.1", 0), Echo)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/v1"
    server.shutdown()
    server.server_close()
    thread.join()


def test_a_key_that_its_endpoint_gives_back_is_never_journaled_kept_or_shown(endpoint: str, tmp_path: Path) -> None:
    pytest.importorskip("openai", reason="the extra openai is not installed")
    journal = tmp_path / "state" / "mind.db"
    journal.parent.mkdir()
    environment = {
        **os.environ,
        "OPENAI_API_KEY": KEY,
        "OPENAI_BASE_URL": endpoint,
        "WAKEFUL_BACKOFF_S": "0",
        "WAKEFUL_BREAKER_FAILURES": "1000",
        "WAKEFUL_CALLS_PER_MINUTE": "none",
        "WAKEFUL_REPLY_CACHE": str(tmp_path / "cache"),
        "XDG_STATE_HOME": str(tmp_path / "xdg"),
        "HOME": str(tmp_path),
    }

    def wakeful(*arguments: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "wakeful", *arguments],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
            env=environment,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout + done.stderr

    shown = wakeful("run", "service_robot", "--events", "24", "--reasoner", "openai", "--journal", str(journal))
    assert set(Echo.heard) == {f"Bearer {KEY}"}, "the endpoint was not asked with the key: the test tests nothing"
    assert len(Echo.ways) >= 12, "too few of the ways were tried"
    for command in ("status", "export"):
        shown += wakeful(command, "--journal", str(journal))
    event = json.loads(wakeful("events", "--json", "--journal", str(journal)))[0]["id"]
    shown += wakeful("why", event, "--journal", str(journal))
    assert KEY not in shown
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert any(path.name == "mind.db" for path in files)
    assert "the key is [key]" in shown, "no reply with the key in it was taken: the test tests nothing"
    for path in files:
        assert KEY.encode() not in path.read_bytes(), path
