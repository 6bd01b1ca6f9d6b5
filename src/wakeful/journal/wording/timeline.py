"""How a process went: its transitions, what it asked and what it was answered, as a timeline in words."""

from __future__ import annotations

from collections.abc import Sequence

from wakeful.facts.asking import Kind
from wakeful.facts.lines import Answered, Asked, Line, Moved
from wakeful.facts.processes import State, Trigger
from wakeful.journal.history import History
from wakeful.journal.wording.answers import answer_words
from wakeful.journal.wording.waiting import asked_words, mover
from wakeful.journal.wording.words import count, plain


def timeline(read: History, trail: Sequence[Line]) -> list[tuple[int, str]]:
    """What a process did, in order: kernel time and words. A request and an answer at once make one entry.

    Args:
        read: the journal's history, for the names of other processes.
        trail: the process's transitions, requests and answers.
    """
    entries: list[tuple[int, str]] = []
    asked: Asked | None = None
    preempted = False
    for index, line in enumerate(trail):
        following = trail[index + 1].record if index + 1 < len(trail) else None
        record = line.record
        if isinstance(record, Asked):
            asked = record
            if not isinstance(following, Answered):
                entries.append((line.at_ns, _waits(record)))
        elif isinstance(record, Answered):
            at_once = index > 0 and isinstance(trail[index - 1].record, Asked)
            late = isinstance(following, Moved) and following.trigger is Trigger.EXPIRE
            entries.append((line.at_ns, _answered(asked, record, at_once, late)))
        elif isinstance(record, Moved):
            text = _moved(read, record, preempted)
            preempted = record.trigger in (Trigger.PREEMPT, Trigger.RESTART)
            if text:
                entries.append((line.at_ns, text))
    return entries


def _waits(asked: Asked) -> str:
    if asked.kind is Kind.SLEEP:
        return "waits for time to pass"
    pieces = f" ({asked.count} pieces)" if asked.count > 1 else ""
    return f"asks for {asked_words(asked)}{pieces}, and waits"


def _answered(asked: Asked | None, answered: Answered, at_once: bool, late: bool) -> str:
    value = answer_words(answered)
    if answered.kind is Kind.RECALL:
        return f"recalls {value}"
    if answered.kind is Kind.SLEEP:
        return "goes on, the time has passed"
    if late:
        return "nothing more came in time" + (f"; it has {value}" if value and not answered.error else "")
    if answered.error:
        return f"gets no answer: {plain(answered.error)}"
    if at_once and asked is not None:
        return f"asks for {asked_words(asked)}, which is there: {value}"
    return f"gets {value or 'nothing'}"


def _moved(read: History, moved: Moved, preempted: bool) -> str:
    """A transition in words. Going on after an answer says nothing; going on after a preemption does."""
    steps = f" after {count(moved.steps, 'step')}" if moved.steps else ""
    match moved.trigger:
        case Trigger.DISPATCH:
            return "begins to think" if moved.before is State.CREATED else "goes on" if preempted else ""
        case Trigger.PREEMPT:
            return f"is preempted by {mover(read, moved.by)}{steps}"
        case Trigger.ASK | Trigger.WAKE | Trigger.EXPIRE:
            return ""
        case Trigger.RESTART:
            return "starts again from its event"
        case Trigger.RESOLVE:
            return f"concludes{steps}"
        case Trigger.FAIL:
            return f"ends unresolved{steps}: a better treatment is owed"
        case Trigger.MOOT:
            return f"becomes moot: {plain(moved.by) or 'its condition cleared'}"
        case Trigger.CANCEL:
            return f"is cancelled by {plain(moved.by) or 'an operator'}"
        case _:
            return "is abandoned: its event is uncovered"
