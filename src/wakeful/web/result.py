"""What a process concluded: its sentence, the treatment's own fields, grounds, proposals and forecast."""

from __future__ import annotations

from collections.abc import Sequence

from wakeful.facts.values import Value
from wakeful.journal.results import result_fields
from wakeful.journal.story import ProcessStory
from wakeful.journal.views import History, Story
from wakeful.journal.wording.results import forecast_words, ground_words, own_lines, proposal_words
from wakeful.web.address import address
from wakeful.web.markup import Child, Markup, clean, element, join

_SHOWN = 8
_LONGEST = 2_000


def result(read: History, told: Story, process: ProcessStory) -> Markup:
    """The typed result in words; one sentence where there is none yet."""
    fields = result_fields(process.result)
    if not fields:
        says = f"It ended {process.end} without a result." if process.end else "Nothing yet."
        return element("p", says, class_="calm")
    confidence = fields.get("confidence")
    sure = [f"{confidence:.2f}"] if isinstance(confidence, int | float) else []
    rows: list[tuple[str, list[Child]]] = [
        ("forecast", _cut([forecast_words(told, process)])),
        *((name, _cut(lines)) for name, lines in own_lines(fields)),
        ("rests on", [_ground(read, told, str(each)) for each in _listed(fields.get("rests_on"))]),
        ("would change it", _cut([str(each) for each in _listed(fields.get("would_change"))])),
        ("proposes", _cut([proposal_words(each) for each in _listed(fields.get("proposes")) if isinstance(each, dict)])),
        ("confidence", _cut(sure)),
    ]
    return join(
        element("p", clean(str(fields.get("says", "")), _LONGEST), class_="lead"),
        element("dl", *(_row(name, lines) for name, lines in rows if any(lines)), class_="rows"),
    )


def _cut(lines: Sequence[str]) -> list[Child]:
    return [clean(line, _LONGEST) for line in lines]


def _ground(read: History, told: Story, ground: str) -> Child:
    """What a result rests on; another event as the way to its page."""
    words = clean(ground_words(read, told, ground), _LONGEST)
    identity = ground.removeprefix("event ")
    linked = identity in read.events and identity != told.event.id
    return element("a", words, href=address(identity)) if linked else words


def _listed(value: Value) -> Sequence[Value]:
    return value if isinstance(value, list) else []


def _row(name: str, lines: Sequence[Child]) -> Markup:
    more = len(lines) - _SHOWN
    return join(
        element("dt", clean(name, 60)),
        *(element("dd", line) for line in lines[:_SHOWN]),
        element("dd", f"and {more} more") if more > 0 else None,
    )
