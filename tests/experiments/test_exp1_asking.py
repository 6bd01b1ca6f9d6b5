"""Who deliberates in Experiment 1: the stand-in by default, and a real endpoint whose answers are kept for the next run."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from wakeful.deliberation import SettingsError
from wakeful.experiments.exp1_asking import Asking
from wakeful.experiments.exp1_events import events
from wakeful.experiments.worlds.service_events import TREATMENTS, A, world


class Model(ThreadingHTTPServer):
    """An endpoint on this machine that always says planning, and counts."""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Answering)
        self.calls = 0


class Answering(BaseHTTPRequestHandler):
    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["content-length"]))
        assert isinstance(self.server, Model)
        self.server.calls += 1
        said = {"choice": "planning", "confidence": 0.8, "forecast": "none", "forecast_probability": 0.6, "because": ["so"]}
        choice = {"index": 0, "message": {"role": "assistant", "content": json.dumps(said)}, "finish_reason": "stop"}
        body = json.dumps({"id": "1", "object": "chat.completion", "created": 0, "model": "m", "choices": [choice]}).encode()
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Model]:
    pytest.importorskip("openai")
    server = Model()
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    monkeypatch.setenv("WAKEFUL_OPENAI_BASE_URL", f"http://127.0.0.1:{server.server_address[1]}/v1")
    monkeypatch.setenv("WAKEFUL_REPLY_CACHE", str(tmp_path / "replies"))
    yield server
    server.shutdown()
    server.server_close()
    thread.join()


def test_a_run_can_be_repeated_without_asking_the_model_again(model: Model) -> None:
    of = world(A, 5000)
    some = events(of, "test")[:6]
    with Asking("openai") as asking:
        first = asking.answers(of, some)
    assert first == {event.id: "planning" for event in some}
    assert model.calls == 6
    with Asking("openai") as asking:
        assert asking.answers(of, some) == first
        assert asking.describe() == "the reasoner openai"
    assert model.calls == 6


def test_without_an_endpoint_the_setting_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("WAKEFUL_OPENAI_BASE_URL", raising=False)
    monkeypatch.delenv("OPENAI_BASE_URL", raising=False)
    with pytest.raises(SettingsError, match="WAKEFUL_OPENAI_BASE_URL"):
        Asking("openai")


def test_the_stand_in_knows_every_event_and_says_how_it_errs() -> None:
    of = world(A, 5001)
    asked = (*events(of, "calibration"), *events(of, "test"))
    with Asking("stand-in") as asking:
        found = asking.answers(of, asked)
        assert "90 % of the abnormal unknown object (says diagnosis)" in asking.describe()
        assert found == asking.answers(of, asked[::-1])
    assert set(found) == {event.id for event in asked}
    assert set(found.values()) <= set(TREATMENTS)


def test_the_guidelines_answer_without_seeing_a_label() -> None:
    of = world(A, 5001)
    asked = events(of, "test")
    with Asking("guidelines") as asking:
        found = asking.answers(of, asked)
    right = sum(found[event.id] == case.truth for event, case in zip(asked, of.test, strict=True))
    assert 0.5 < right / len(asked) < 1.0
