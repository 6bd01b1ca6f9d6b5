"""What a person should look at in a journal: processes that did not go on as they were, and what changed under them."""

from __future__ import annotations

from wakeful.facts.crashes import CRASHED, QUARANTINED
from wakeful.facts.named import MISMATCH, MODEL_LEFT, REMOVED
from wakeful.journal.history import History
from wakeful.journal.readable import View

#: In this order, and in these words.
WORDS = {
    CRASHED: "events that were being treated when the mind's process ended",
    QUARANTINED: "not treated any more: their treatment ended the mind's process every time; in debt",
    MISMATCH: "began again from their events: their code no longer matches what was recorded",
    REMOVED: "go on in fallback mode: their treatment is not registered any more; in debt",
    MODEL_LEFT: "the model was fitted to another version of the domain; guidelines decide until the next one",
}


class Named(View, frozen=True):
    """One kind of thing to look at. ``processes`` are those that it befell, in order; ``open`` how many of them still are.

    ``events`` where it befell events whose process nobody knows, ``detail`` what the last note said.
    """

    what: str
    means: str
    times: int
    processes: tuple[int, ...]
    open: int
    events: tuple[str, ...]
    detail: str


def named(read: History) -> list[Named]:
    """What is to be looked at; empty where everything went on as it was."""
    found = []
    for what, means in WORDS.items():
        notes = [note for _, note in read.noted if note.what == what]
        if not notes:
            continue
        processes = tuple(dict.fromkeys(note.process for note in notes if note.process))
        found.append(
            Named(
                what=what,
                means=means,
                times=len(notes),
                processes=processes,
                open=sum(1 for each in processes if each in read.processes and read.processes[each].open),
                events=tuple(dict.fromkeys(note.event for note in notes if note.event and not note.process)),
                detail=notes[-1].detail,
            )
        )
    return found + _domains(read)


def _domains(read: History) -> list[Named]:
    versions: dict[str, list[int]] = {}
    for opened in read.opened:
        known = versions.setdefault(opened.domain, [])
        if not known or known[-1] != opened.domain_version:
            known.append(opened.domain_version)
    return [
        Named(
            what="domain changed",
            means=f"domain {name} changed under this journal, version {' to '.join(map(str, known))}",
            times=len(known) - 1,
            processes=(),
            open=0,
            events=(),
            detail="",
        )
        for name, known in versions.items()
        if len(known) > 1
    ]
