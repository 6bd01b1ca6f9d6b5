"""What is being thought about now: open processes by state, the most critical first."""

from __future__ import annotations

from wakeful.facts.processes import State
from wakeful.journal.overload import backlog
from wakeful.journal.rows import ProcessRow, process_row
from wakeful.journal.views import History
from wakeful.journal.wording.events import CRITICALITY
from wakeful.journal.wording.waiting import deadline_words
from wakeful.journal.wording.words import count, duration
from wakeful.web.address import address, name_of
from wakeful.web.figures import MODE_WORDS
from wakeful.web.markup import Markup, clean, element

SHOWN = 60
"""At most so many of each state; the rest are counted."""

_LONGEST = 140
_STATES = {
    State.ACTIVE: "Thinking",
    State.WAITING: "Waiting for evidence, an answer or a timer",
    State.SUSPENDED: "Suspended, ready to go on",
    State.CREATED: "Ready, not begun",
}
_COLUMNS = ("Event", "Treatment", "Criticality", "Age", "Deadline", "Stands")


def now(read: History) -> Markup:
    """The open processes as a table with a group for each state; one sentence where none is open."""
    rows = [process_row(read, process) for process in read.processes.values() if process.open]
    if not rows:
        done = "Everything that was admitted has been thought through." if read.events else "No event has been admitted yet."
        return element("p", done, class_="calm")
    found = {state: [row for row in rows if row.state == state] for state in _STATES}
    waits = backlog(read)
    late = f"{count(waits.not_begun, 'event')} not begun, the oldest for {duration(waits.oldest_s)}." if waits.not_begun else ""
    return element(
        "div",
        element("p", late, class_="backlog") if late else None,
        element(
            "table",
            element("caption", "Open processes", class_="unseen"),
            element("thead", element("tr", *(element("th", column, scope="col") for column in _COLUMNS))),
            *(_group(read, state, found[state]) for state in _STATES if found[state]),
        ),
        class_="scroll",
    )


def _group(read: History, state: State, rows: list[ProcessRow]) -> Markup:
    far = float("inf")
    ranked = sorted(rows, key=lambda row: (-row.criticality, far if row.deadline_s is None else row.deadline_s, row.id))
    left_out = len(ranked) - SHOWN
    return element(
        "tbody",
        element(
            "tr",
            element("th", f"{_STATES[state]} ({len(rows)})", scope="rowgroup", colspan=len(_COLUMNS)),
            class_=f"group {state.value}",
        ),
        *(_row(read, row) for row in ranked[:SHOWN]),
        element("tr", element("td", f"and {count(left_out, 'more process', 'more processes')}", colspan=len(_COLUMNS)))
        if left_out > 0
        else None,
    )


def _row(read: History, row: ProcessRow) -> Markup:
    past = read.events.get(row.event)
    about = name_of(past.event.kind, past.event.entity or past.event.robot) if past else f"event {row.event[:10]}"
    says = clean(past.event.says, _LONGEST) if past else ""
    link = f"reopens {row.reopens}" if row.reopens else f"for process {row.parent}" if row.parent else ""
    late = row.deadline_s is not None and row.deadline_s < 0
    return element(
        "tr",
        element(
            "td",
            element("a", about, href=address(row.event), id=f"now-{row.id}"),
            element("small", says) if says else None,
            element("small", f"process {row.id}" + (f", {link}" if link else "")),
            data_label="Event",
            class_="about",
        ),
        element("td", clean(row.treatment, 60), element("small", MODE_WORDS.get(row.mode, "")), data_label="Treatment"),
        element("td", grade(row.criticality), data_label="Criticality"),
        element("td", duration(row.age_s), element("small", f"{duration(row.in_state_s)} in this state"), data_label="Age"),
        element("td", deadline_words(row.deadline_s), data_label="Deadline", class_="bad" if late else None),
        element("td", row.stands, data_label="Stands"),
    )


def grade(criticality: int) -> Markup:
    """A criticality as a word with a mark."""
    return element("span", CRITICALITY[criticality], class_=f"grade grade-{criticality}")
