"""How a process went: its transitions, what it asked and what it was answered, as a timeline in words."""

from __future__ import annotations

from wakeful.cli.terminal import heading, paragraph
from wakeful.facts.processes import State
from wakeful.facts.time import to_s
from wakeful.journal.story import ProcessStory
from wakeful.journal.views import History, Story
from wakeful.journal.wording.timeline import timeline
from wakeful.journal.wording.words import count, duration

_INSTANT = 13
_FIRST, _LAST = 14, 4
"""Of a long timeline so many lines from the beginning and from the end are shown."""


def print_thinking(read: History, told: Story, process: ProcessStory) -> None:
    """Print the timeline of one process, instants counted from the event's admission."""
    heading(f"Thinking (process {process.id})")
    lines = timeline(read, process.trail)
    left_out = range(_FIRST, len(lines) - _LAST) if len(lines) > _FIRST + _LAST + 1 else range(0)
    for index, (at_ns, text) in enumerate(lines):
        if index == left_out.start and left_out:
            paragraph(f"… {count(len(left_out), 'more entry', 'more entries')}; --json shows all", 2 + _INSTANT)
        if index not in left_out:
            paragraph(text, 2, _INSTANT, f"+{duration(to_s(at_ns - told.admitted_ns))}".ljust(_INSTANT))
    if process.state != State.COMPLETED:
        held = f", held by {process.held_by}" if process.held_by else ""
        paragraph(f"now {process.state}{held}", 2, _INSTANT, " " * _INSTANT)
    for note in process.notes:
        paragraph(f"note: {note.what}: {note.detail}", 2, _INSTANT, " " * _INSTANT)
