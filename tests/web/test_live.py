"""Changes arrive as server-sent events; the clock is the test's own."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from tests.journal.builder import Book
from tests.web.conftest import Browse, write
from tests.web.documents import Parsed
from wakeful.web.live import position_of


class Clock:
    """Does at each pause the next thing of a list, and ends the stream after the last."""

    def __init__(self, *steps: Callable[[], object]) -> None:
        self.steps = list(steps)
        self.paused_s: list[float] = []
        self.ended = False

    async def pause(self, seconds: float) -> None:
        self.paused_s.append(seconds)
        if self.steps:
            self.steps.pop(0)()
        else:
            self.ended = True

    def ending(self) -> bool:
        return self.ended


def messages(text: str) -> list[dict[str, str]]:
    """The events of a stream, each by its fields."""
    return [
        dict(line.split(": ", 1) for line in block.splitlines())
        for block in text.split("\n\n")
        if block and not block.startswith(":")
    ]


def followed(browse: Browse, path: Path, clock: Clock) -> TestClient:
    return browse(path, pause=clock.pause, ending=clock.ending)


def test_a_growing_journal_comes_through_the_stream(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    path = write(book, tmp_path / "j.db")

    def grow() -> None:
        book.admit("grip_lost", "<gripper>")
        write(book, path)

    clock = Clock(grow, lambda: None, grow)
    answer = followed(browse, path, clock).get("/live?after=1")
    assert answer.headers["content-type"].startswith("text/event-stream")
    _, first, second = messages(answer.text)
    assert [first["id"], second["id"]] == ["4", "7"]
    parts = json.loads(first["data"])["parts"]
    assert set(parts) == {"source", "figures", "now", "events", "curve", "strange"}
    assert "grip_lost of <gripper>" in Parsed(parts["events"]).text
    again = json.loads(second["data"])["parts"]
    assert {"figures", "now", "events"} <= set(again)
    assert "curve" not in again, "what has not changed is not sent again"


def test_a_page_that_is_up_to_date_gets_nothing_until_something_happens(browse: Browse, journal: Path, book: Book) -> None:
    clock = Clock(*[lambda: None] * 40)
    answer = followed(browse, journal, clock).get(f"/live?after={len(book.written)}")
    assert [message for message in messages(answer.text) if "data" in message] == []
    assert ": still here" in answer.text
    assert min(clock.paused_s) >= 0.5


def test_a_reader_that_comes_back_goes_on_where_it_was(browse: Browse, journal: Path, book: Book) -> None:
    last = str(len(book.written))
    current = followed(browse, journal, Clock()).get("/live?after=1", headers={"last-event-id": last})
    behind = followed(browse, journal, Clock()).get("/live?after=1", headers={"last-event-id": "7"})
    assert "data" not in current.text
    assert messages(behind.text)[-1]["id"] == last


def test_the_stream_keeps_to_the_pages_filter(browse: Browse, journal: Path, book: Book) -> None:
    answer = followed(browse, journal, Clock()).get("/live?kind=grip_lost")
    events = Parsed(json.loads(messages(answer.text)[-1]["data"])["parts"]["events"])
    assert events.links == [f"/event/{book.event_of(2)}"]


def test_the_page_of_an_event_is_followed_too(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    process = book.admit()
    path = write(book, tmp_path / "j.db")

    def think() -> None:
        book.run_through(process)
        write(book, path)

    answer = followed(browse, path, Clock(think)).get(f"/event/{book.event_of(process)}/live?after=4")
    parts = json.loads(messages(answer.text)[-1]["data"])["parts"]
    assert set(parts) == {"source", "title", "why"}
    assert "joint 3 runs warm" in parts["why"]


def test_a_journal_that_goes_is_told_once_and_followed_again_when_it_is_back(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    path = write(book, tmp_path / "j.db")

    def remove() -> None:
        for file in tmp_path.glob("j.db*"):
            file.unlink()

    def renew() -> None:
        later = Book()
        later.admit("new_kind")
        write(later, path)

    clock = Clock(remove, lambda: None, renew)
    _, trouble, back = messages(followed(browse, path, clock).get("/live?after=1").text)
    assert trouble["event"] == "trouble"
    assert "has gone" in json.loads(trouble["data"])["says"]
    assert "new_kind" in json.loads(back["data"])["parts"]["events"]


def test_an_event_that_goes_with_its_journal_is_said_to_be_unknown(browse: Browse, journal: Path) -> None:
    answer = followed(browse, journal, Clock()).get("/event/0000000000/live")
    assert set(json.loads(messages(answer.text)[-1]["data"])["parts"]) == {"source"}


def test_more_streams_than_allowed_are_refused(browse: Browse, journal: Path) -> None:
    answer = browse(journal, most_streams=0).get("/live")
    assert answer.status_code == 503
    assert answer.headers["retry-after"] == "10"


def test_a_stream_that_ended_makes_room(browse: Browse, journal: Path) -> None:
    clock = Clock()
    client = browse(journal, pause=clock.pause, ending=clock.ending, most_streams=1)
    assert [client.get("/live").status_code for _ in range(3)] == [200, 200, 200]


@pytest.mark.parametrize(
    ("header", "query", "position"), [("7", "3", 7), ("", "3", 3), ("-1", "x", 0), ("", "", 0), ("9" * 99, "٣", 0)]
)
def test_a_position_is_a_plain_number_or_none(header: str, query: str, position: int) -> None:
    assert position_of(header, query) == position
