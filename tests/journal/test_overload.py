"""The backlog as a journal tells it: what waits, for how long, when it was worst, what was shed and refused."""

from __future__ import annotations

import msgspec

from tests.journal.builder import Book, decision
from wakeful.facts.crashes import CRASHED, QUARANTINED
from wakeful.facts.lines import Acted, Decided, Noted, Refused
from wakeful.facts.named import MISMATCH
from wakeful.facts.overload import REFUSED, SHED
from wakeful.facts.processes import Trigger
from wakeful.journal.named import named
from wakeful.journal.overload import backlog
from wakeful.journal.views import history
from wakeful.web.now import now


def test_an_empty_journal_has_no_backlog() -> None:
    found = backlog(history(Book()))
    assert (found.not_begun, found.oldest_s, found.most, found.worst_s, found.shed, found.refused) == (0, 0.0, 0, 0.0, 0, {})


def test_what_has_not_begun_is_counted_with_the_age_of_the_oldest_and_the_worst_instant() -> None:
    book = Book()
    first = book.admit()
    book.wait(2.0)
    second = book.admit(criticality=3)
    book.wait(3.0)
    book.move(first, Trigger.DISPATCH)
    book.move(second, Trigger.DISPATCH)
    book.admit()
    book.wait(1.5)
    book.admit()
    found = backlog(history(book))
    assert (found.not_begun, found.oldest_s, found.most) == (2, 1.5, 2)
    assert (found.worst_s, found.worst_critical_s) == (5.0, 3.0)


def test_what_an_operator_holds_is_no_backlog() -> None:
    book = Book()
    process = book.admit()
    book.write(Acted(who="ann", act="hold", process=process, why="a test"))
    assert backlog(history(book)).not_begun == 0


def test_what_was_shed_and_what_was_refused_for_overload_is_told_apart_from_other_refusals() -> None:
    book = Book()
    process = book.admit()
    event = book.event_of(process)
    kept = history(book).processes[process].decision
    assert kept is not None
    provisional = msgspec.structs.replace(kept, mode="fallback", reasons=(f"{SHED}, 600 events wait", *kept.reasons))
    book.written[-1] = msgspec.structs.replace(
        book.written[-1], record=Decided(process=process, event=event, decision=provisional)
    )
    book.write(Refused(source="s", position=7, reason=f"{REFUSED}, the backlog has reached 4000"))
    book.write(Refused(source="s", position=8, reason="an event needs a kind"))
    found = backlog(history(book))
    assert found.shed == 1
    assert found.refused == {f"{REFUSED}, the backlog has reached 4000": 1}
    assert decision("description", "auto").reasons[:1] != provisional.reasons[:1]


def test_the_page_tells_the_backlogs_age() -> None:
    book = Book()
    book.admit()
    book.wait(90.0)
    book.admit()
    assert "2 events not begun, the oldest for" in str(now(history(book)))


def test_each_kind_of_thing_to_look_at_is_named_once_with_its_processes() -> None:
    book = Book()
    first, second = book.admit(), book.admit()
    for process in (first, second, first):
        book.write(Noted(what=MISMATCH, detail="request 2", process=process, event=book.event_of(process)))
    book.write(Noted(what=CRASHED, detail="run", event="0123456789abcdef0123"))
    book.write(Noted(what=QUARANTINED, detail="3 times", process=second, event=book.event_of(second)))
    book.write(Noted(what="resumption", detail="not to look at", process=second))
    found = {each.what: each for each in named(history(book))}
    assert list(found) == [CRASHED, QUARANTINED, MISMATCH]
    assert (found[MISMATCH].times, found[MISMATCH].processes, found[MISMATCH].open) == (3, (first, second), 2)
    assert found[CRASHED].events == ("0123456789abcdef0123",)
