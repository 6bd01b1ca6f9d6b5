"""What an open process stands on, in words: what it waits for, who preempted it, who holds it."""

from __future__ import annotations

from wakeful.facts.asking import Kind
from wakeful.facts.lines import Asked
from wakeful.facts.processes import State, Trigger
from wakeful.facts.time import to_s
from wakeful.journal.history import History, ProcessPast, waits_for
from wakeful.journal.wording.words import duration, plain

_ASKS: dict[Kind, str] = {
    Kind.EVIDENCE: "evidence {}",
    Kind.RECALL: "memory of {}",
    Kind.DELIBERATE: "the reasoner's answer on {}",
    Kind.ASK: "a person's answer: {}",
    Kind.TREAT: "its child's {}",
    Kind.CALL: "the call {}",
    Kind.SLEEP: "time to pass",
}


def asked_words(asked: Asked) -> str:
    """What was asked for."""
    key = plain(asked.key.replace("\x1f", " of "), 60)
    return _ASKS[asked.kind].format(key or "anything")


def limit_words(asked: Asked, now_ns: int) -> str:
    """Until when at most."""
    return "" if asked.expires_ns is None else f", at most {duration(to_s(asked.expires_ns - now_ns))} more"


def deadline_words(seconds: float | None) -> str:
    """How long until a deadline, or how long ago it passed."""
    if seconds is None:
        return "–"
    return f"in {duration(seconds)}" if seconds >= 0 else f"passed {duration(-seconds)} ago"


def stands(read: History, process: ProcessPast) -> str:
    """One sentence on why the process is where it is; empty for one that is done."""
    if process.held_by:
        why = f" ({plain(process.held_why, 60)})" if process.held_why else ""
        return f"held by {plain(process.held_by)}{why}"
    match process.state:
        case State.CREATED:
            return "ready, not begun"
        case State.ACTIVE:
            return "thinking"
        case State.WAITING:
            asks = waits_for(process)
            return "waits for " + "; ".join(asked_words(asked) + limit_words(asked, read.now_ns) for asked in asks)
        case State.SUSPENDED:
            return {
                Trigger.PREEMPT: f"ready; preempted by {mover(read, process.by)}",
                Trigger.WAKE: "ready; its answer came",
                Trigger.EXPIRE: "ready; what it waited for did not come in time",
                Trigger.RESTART: "ready; started again from its event",
            }.get(process.trigger or Trigger.PREEMPT, "ready")
        case _:
            return ""


def mover(read: History, by: str) -> str:
    """The process that preempted, with its event's kind; whatever else it is as it stands."""
    number = by.removeprefix("P")
    if number.isdigit() and int(number) in read.processes:
        other = read.processes[int(number)]
        past = read.events.get(other.event)
        return f"process {number} ({past.event.kind} of {past.event.entity})" if past else f"process {number}"
    return plain(by) or "another process"
