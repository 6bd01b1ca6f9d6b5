"""Log lines of one wording are one condition."""

from __future__ import annotations

from tests.registration.watching import detector, seen
from wakeful.contracts.detector import Found
from wakeful.facts.events import Phase
from wakeful.facts.values import Value


def log(lines: list[tuple[float, Value, str]], **settings: int | float | str) -> list[tuple[str, Phase | None]]:
    watcher = detector("text", ("log/text",), **settings)
    found = []
    for index, (at_s, level, text) in enumerate(lines):
        found += [item for item in watcher.observe(seen(index, at_s, "log", level=level, text=text)) if isinstance(item, Found)]
    return [(item.type, item.phase) for item in found]


def test_lines_of_one_wording_repeat_one_condition() -> None:
    lines: list[tuple[float, Value, str]] = [
        (0, 30, "motor 3 at 81 C"),
        (1, 30, "motor 1 at 99.5 C"),
        (90, 30, "motor 3 at 80 C"),
    ]
    wording = "motor # at # C"
    assert log(lines) == [(wording, Phase.RAISED), (wording, Phase.REPEATED), (wording, Phase.RAISED)]


def test_lines_below_the_level_are_passed_over() -> None:
    lines: list[tuple[float, Value, str]] = [
        (0, 20, "fine"),
        (1, "INFO", "fine too"),
        (2, "Error", "bad"),
        (3, 50, "worse"),
        (4, None, "?"),
    ]
    assert [wording for wording, _ in log(lines)] == ["bad", "worse", "?"]
    assert log(lines, least=50, match="^w") == [("worse", Phase.RAISED)]
