"""What an operator sees, as HTML that needs no script."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.journal.builder import Book, raw
from tests.web.conftest import Browse, write
from tests.web.documents import Parsed
from wakeful.facts.lines import Concluded, Noted
from wakeful.facts.processes import Trigger
from wakeful.facts.results import Forecast

HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(2)>&lt;b&gt;\u202e</p></li>javascript:alert(3)"


def test_the_head_adds_up(browse: Browse, journal: Path) -> None:
    text = Parsed(browse(journal).get("/").text).text
    for expected in (
        "Coverage 100 %",
        "Completion 71.4 % 5 resolved",
        "Received 9 = 7 admitted + 1 duplicate + 1 refused",
        "Debt 1",
        "Automatic 42.9 %",
        "arm.xlsx (arm)",
    ):
        assert expected in text, expected


def test_now_says_what_each_process_waits_for_and_what_is_ready(browse: Browse, journal: Path) -> None:
    text = Parsed(browse(journal).get("/").text).text
    assert "Waiting for evidence, an answer or a timer (1)" in text
    assert "waits for evidence camera|joint_3, at most 60.0 s more" in text
    assert "Ready, not begun (1)" in text


def test_now_says_who_preempted_with_the_critical_first(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    first = book.admit()
    book.move(first, Trigger.DISPATCH)
    urgent = book.admit("grip_lost", "gripper", criticality=3)
    book.move(first, Trigger.PREEMPT, by=str(urgent))
    text = Parsed(browse(write(book, tmp_path / "j.db")).get("/").text).text
    assert "ready; preempted by process 2 (grip_lost of gripper)" in text
    assert "Suspended, ready to go on (1)" in text
    assert "critical" in text


def test_an_empty_journal_says_so(browse: Browse, tmp_path: Path) -> None:
    text = Parsed(browse(write(Book(), tmp_path / "j.db")).get("/").text).text
    assert "No event has been admitted yet." in text


def test_the_latest_event_comes_first_with_what_was_concluded(browse: Browse, journal: Path, book: Book) -> None:
    parsed = Parsed(browse(journal).get("/").text)
    events = [link for link in parsed.links if link.startswith("/event/")]
    assert events.index(f"/event/{book.event_of(1)}") > events.index(f"/event/{book.event_of(7)}")
    assert "joint 3 runs warm" in parsed.text


@pytest.mark.parametrize(
    ("query", "processes"),
    [
        ("kind=grip_lost", [2]),
        ("mode=auto", [5, 6, 7]),
        ("verdict=contradicted", [1]),
        ("text=JOINT_2", [9]),
        ("text=runs+warm&mode=fallback", [2]),
        ("only=open", [8, 9]),
        ("only=debt", [2]),
        ("kind=nothing", []),
        ("mode=quick&verdict=maybe&before=-3&only=x", [1, 2, 5, 6, 7, 8, 9]),
    ],
)
def test_a_filter_lets_through_what_it_says(browse: Browse, journal: Path, book: Book, query: str, processes: list[int]) -> None:
    parsed = Parsed(browse(journal).get(f"/?{query}").text)
    listed = {each["id"] for each in parsed.all("a") if each.get("id", "").startswith("event-")}
    found = {each["href"] for each in parsed.all("a") if each.get("id") in listed}
    assert found == {f"/event/{book.event_of(process)}" for process in processes}


def test_a_filter_stands_in_its_form_and_in_the_address_of_its_stream(browse: Browse, journal: Path) -> None:
    parsed = Parsed(browse(journal).get("/?text=%22%3E%3Cb&mode=auto").text)
    assert next(each for each in parsed.all("input"))["value"] == '"><b'
    assert [each["value"] for each in parsed.all("option") if "selected" in each and each["value"]] == ["auto"]
    assert parsed.all("body")[0]["data-live"] == "/live?mode=auto&text=%22%3E%3Cb"


def test_earlier_events_are_a_page_further(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    for _ in range(70):
        book.run_through(book.admit())
    client = browse(write(book, tmp_path / "j.db"))
    seen: list[str] = []
    address = "/"
    while address:
        parsed = Parsed(client.get(address.partition("#")[0]).text)
        seen += [each["href"] for each in parsed.all("a") if each.get("id", "").startswith("event-")]
        address = next((each["href"] for each in parsed.all("a") if each.get("id") == "earlier"), "")
    assert seen == [f"/event/{book.event_of(process)}" for process in range(70, 0, -1)]


def test_the_learning_curve_is_a_drawing_and_a_table(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    for index in range(40):
        process = book.admit(mode="auto" if index >= 20 else "delib")
        book.run_through(process)
        book.judge(process, "none", "none")
    parsed = Parsed(browse(write(book, tmp_path / "j.db")).get("/").text)
    assert "Automatic share from 0 % in the first tenth to 100 % in the last" in parsed.text
    assert len(parsed.all("polyline")) == 2
    assert "10 4 100 % 100 % of 4" in parsed.text


def test_the_page_of_an_event_is_its_story(browse: Browse, journal: Path, book: Book) -> None:
    text = Parsed(browse(journal).get(f"/event/{book.event_of(1)}").text).text
    for expected in (
        "joint_current of joint_3",
        "joint_3: current left its band",
        "diagnosis , with deliberation",
        "0.800",
        "yes confidence 0.800 reaches the threshold 0.700",
        "asks for evidence camera|joint_3, and waits",
        "is preempted by process 2 (grip_lost of gripper)",
        "joint 3 runs warm",
        "gripper wear",
        "the world showed protective_stop; the forecast was none: contradicted",
        "Reopening: process 4 thinks again about what process 1 concluded",
        "because the world contradicted it",
        "Memory for process 1",
        "diagnosis 0.900 → 0.600: contradicted",
    ):
        assert expected in text, expected


def test_an_automatic_event_names_its_model_and_links_what_it_rests_on(browse: Browse, journal: Path, book: Book) -> None:
    client = browse(journal, weighing=lambda _journal, _read, event, decision: [(f"{event.kind} = <i>", 0.5)])
    parsed = Parsed(client.get(f"/event/{book.event_of(5)}").text)
    assert "model version 1" in parsed.text
    assert "Version 1 and what it came from" in parsed.text
    assert "+0.50 joint_current = <i>" in parsed.text
    assert f"/event/{book.event_of(1)}" in parsed.links


def test_the_beginning_of_an_id_is_enough(browse: Browse, journal: Path, book: Book) -> None:
    assert browse(journal).get(f"/event/{book.event_of(1)[:8]}").status_code == 200


def test_an_unknown_event_is_not_found_and_close_ones_are_named(browse: Browse, journal: Path, book: Book) -> None:
    answer = browse(journal).get(f"/event/{book.event_of(1)[:6]}zz")
    parsed = Parsed(answer.text)
    assert answer.status_code == 404
    assert "There is no such event" in parsed.text
    assert f"/event/{book.event_of(1)}" in parsed.links


@pytest.mark.parametrize("path", ["/event/", "/nowhere", "/event/%3Cscript%3E", "/event/..%2f..%2fetc", "/static/none.js"])
def test_what_is_not_there_is_not_found(browse: Browse, journal: Path, path: str) -> None:
    answer = browse(journal).get(path)
    assert answer.status_code == 404
    assert "<script>" not in answer.text


@pytest.fixture
def hostile(tmp_path: Path) -> tuple[Path, str]:
    """A journal whose every text from outside is an attack, and the id of its event."""
    book = Book(source=HOSTILE, domain=HOSTILE)
    process = book.admit(HOSTILE, HOSTILE, treatment=HOSTILE, rests_on=(1,))
    event = book.event_of(process)
    book.move(process, Trigger.DISPATCH)
    seq = book.ask(process, key=HOSTILE)
    book.answer(process, seq, key=HOSTILE, value={"says": HOSTILE}, error="")
    book.move(process, Trigger.DISPATCH, by=HOSTILE)
    fields = {
        "type": HOSTILE,
        "says": HOSTILE,
        "confidence": HOSTILE,
        HOSTILE: [HOSTILE, {HOSTILE: HOSTILE}],
        "rests_on": [HOSTILE, f"event {event}"],
        "would_change": [HOSTILE],
        "proposes": [{"effect": HOSTILE, "preconditions": [HOSTILE]}, 3],
    }
    forecast = Forecast(label=HOSTILE, probability=0.9)
    book.write(Concluded(process=process, event=event, treatment=HOSTILE, mode="delib", result=raw(fields), forecast=forecast))
    book.move(process, Trigger.RESOLVE)
    book.judge(process, "none", HOSTILE, book.witness(HOSTILE, HOSTILE))
    book.write(Noted(what=HOSTILE, detail=HOSTILE, process=process))
    waiting = book.admit(HOSTILE, HOSTILE)
    book.move(waiting, Trigger.DISPATCH)
    book.ask(waiting, key=HOSTILE)
    return write(book, tmp_path / "hostile.db"), event


def test_hostile_text_adds_no_element_and_no_attribute(browse: Browse, hostile: tuple[Path, str]) -> None:
    path, event = hostile
    client = browse(path)
    for address in ("/", f"/event/{event}", f"/?text={'%3Cscript%3E'}&kind=%22onload=x", f"/event/{event[:4]}%3Cimg%20src=x%3E"):
        text = client.get(address).text
        parsed = Parsed(text)
        assert {tag for tag, _ in parsed.elements} <= KNOWN, address
        assert all(each["src"].startswith("/static/") for each in parsed.all("script")), address
        assert not parsed.all("img"), address
        for tag, attributes in parsed.elements:
            assert not [name for name in attributes if name.startswith("on") or name == "style"], (address, tag)
        assert all(link.startswith(("/", "#")) for link in parsed.links), address
        assert "\u202e" not in text, address


KNOWN = {
    *("html", "head", "meta", "title", "link", "script", "body", "header", "main", "footer", "nav", "section", "article", "div"),
    *("h1", "h2", "h3", "h4", "p", "a", "span", "small", "strong", "time", "ol", "ul", "li", "dl", "dt", "dd"),
    *("table", "caption", "thead", "tbody", "tr", "th", "td", "figure", "figcaption", "details", "summary"),
    *("form", "label", "select", "option", "input", "button"),
    *("svg", "rect", "line", "polyline", "circle", "text"),
}


def test_hostile_text_is_shown_as_it_was_written(browse: Browse, hostile: tuple[Path, str]) -> None:
    assert "<script>alert(1)</script>\"'><img src=x onerror=alert(2)>&lt;b&gt;" in Parsed(browse(hostile[0]).get("/").text).text


def test_megabytes_of_text_make_a_bounded_page(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    process = book.admit("k" * 1_000_000, "e" * 1_000_000)
    book.move(process, Trigger.DISPATCH)
    book.conclude(process, says="s" * 1_000_000)
    client = browse(write(book, tmp_path / "j.db"))
    assert len(client.get("/").content) < 60_000
    assert len(client.get(f"/event/{book.event_of(process)}").content) < 60_000


def test_a_page_with_all_its_files_weighs_less_than_sixty_kilobytes(browse: Browse, journal: Path, book: Book) -> None:
    client = browse(journal)
    files = sum(len(client.get(f"/static/{name}").content) for name in ("page.css", "page.js", "icon.svg"))
    for address in ("/", f"/event/{book.event_of(1)}"):
        assert files + len(client.get(address).content) < 60_000


def test_nothing_is_fetched_from_elsewhere(browse: Browse, journal: Path) -> None:
    client = browse(journal)
    for name in ("page.css", "page.js"):
        assert "://" not in client.get(f"/static/{name}").text
    parsed = Parsed(client.get("/").text)
    sources = [each.get("src", each.get("href", "")) for tag in ("script", "link") for each in parsed.all(tag)]
    assert sources
    assert all(each.startswith("/static/") for each in sources)


def test_the_page_can_be_used_by_keyboard_and_ear(browse: Browse, journal: Path) -> None:
    parsed = Parsed(browse(journal).get("/").text)
    ids = [attributes["id"] for _, attributes in parsed.elements if "id" in attributes]
    assert len(ids) == len(set(ids))
    assert parsed.links[0] == "#main"
    assert parsed.all("html")[0]["lang"] == "en"
    assert len(parsed.all("h1")) == 1
    assert all(each.get("scope") for each in parsed.all("th"))
    labelled = [each["aria-labelledby"] for _, each in parsed.elements if "aria-labelledby" in each]
    assert labelled
    assert set(labelled) <= set(ids)
    assert len(parsed.all("label")) == len(parsed.all("select")) + len(parsed.all("input"))
