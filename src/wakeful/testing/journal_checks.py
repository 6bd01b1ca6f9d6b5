"""The contract that every journal keeps: what was committed is there, in order; what was refused has left nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from wakeful.contracts.journal import Journal, JournalError
from wakeful.facts.choices import Basis, Choice
from wakeful.facts.events import Event
from wakeful.facts.lines import Line, Noted
from wakeful.facts.packs import Covered, Entry, Pack, expanded
from wakeful.facts.time import Stamp
from wakeful.testing.broken import ContractBroken, require


def check_journal(open_journal: Callable[[], Journal], durable: bool = True) -> None:
    """Commit, refuse, close and open again.

    Args:
        open_journal: opens the journal; called again after ``close``, it must open the same one where ``durable``.
        durable: whether what was committed outlives ``close``.

    Raises:
        ContractBroken: it does not keep its contract.
    """
    journal = open_journal()
    require(journal.last == 0 and not list(journal.lines()) and not journal.state(), "a new journal must be empty")
    first = _lines(1, 3)
    journal.commit(first, {"a": b"1", "b": b"2"}, {"model": b"\x00weights"})
    _expect(journal, first, {"a": b"1", "b": b"2"})
    require(journal.blob("model") == b"\x00weights", "a blob must come back as it was committed")
    second = _lines(4, 2)
    journal.commit(second, {"a": None, "c": b""}, {})
    _expect(journal, (*first, *second), {"b": b"2", "c": b""})
    require(tuple(journal.lines(after=3)) == second, "lines(after=3) must begin with position 4")
    journal.commit((), {"b": b"3"}, {})
    _expect(journal, (*first, *second), {"b": b"3", "c": b""})

    while journal.tidy(1):
        pass
    _expect(journal, (*first, *second), {"b": b"3", "c": b""})
    for wrong in (_lines(9, 1), _lines(5, 1), (*_lines(6, 1), *_lines(8, 1))):
        _refused(journal, wrong)
        _expect(journal, (*first, *second), {"b": b"3", "c": b""})
    _no_blob(journal, "none")
    if not durable:
        _packed(journal)
    journal.close()
    if durable:
        again = open_journal()
        _expect(again, (*first, *second), {"b": b"3", "c": b""})
        require(again.blob("model") == b"\x00weights", "a blob must outlive the journal's closing")
        again.commit(_lines(6, 1), {}, {})
        require(again.last == 6, "an opened journal must go on at its last position")
        _packed(again)
        again.close()


def _packed(journal: Journal) -> None:
    """A pack's lines are there one by one, between those of other entries, and recovery gets what stands for the same."""
    pack = Pack(journal.last + 1, 7_000, _burst())
    entries: tuple[Entry, ...] = (pack, *_lines(pack.last + 1, 1))
    journal.commit(entries, {}, {})
    before = pack.position - 1
    require(journal.last == pack.last + 1, "a pack counts as many positions as it has lines")
    require(tuple(journal.lines(before)) == tuple(expanded(entries)), "a pack must read back as its lines")
    require(tuple(journal.lines(pack.position)) == tuple(expanded(entries))[1:], "lines(after) may begin within a pack")
    require(tuple(expanded(journal.entries(before))) == tuple(expanded(entries)), "entries must stand for the same lines")
    require(tuple(journal.entries(pack.last)) == entries[1:], "entries(after) must begin with the next one")


def _burst() -> Covered:
    event = Event(id="e", kind="check", entity="journal", source="check", position=0, stamp=Stamp(source_ns=1))
    basis = Basis(
        treatment="memory",
        model=1,
        watermark=9,
        treatments=("memory", "planning"),
        labels=("none",),
        threshold=0.5,
        result_threshold=0.5,
        novelty_limit=0.9,
        trust_limit=0.4,
        support=3,
    )
    choice = Choice(basis=basis, shares=(0.9, 0.1), prior=(1.0,), novelty=0.1, trust=0.8, rests_on=(7, 2))
    return Covered(event=event, process=1, choice=choice)


def _lines(start: int, count: int) -> tuple[Line, ...]:
    return tuple(
        Line(position, position * 1_000, Noted(what="check", detail=f"line {position} – “ü”"))
        for position in range(start, start + count)
    )


def _expect(journal: Journal, lines: Sequence[Line], state: Mapping[str, bytes]) -> None:
    require(tuple(journal.lines()) == tuple(lines), "the lines must come back as they were committed, in order")
    require(journal.last == len(lines), f"last is {journal.last}, but {len(lines)} lines were committed")
    require(journal.state() == dict(state), f"the state is {journal.state()}, but must be {dict(state)}")


def _refused(journal: Journal, lines: Sequence[Line]) -> None:
    try:
        journal.commit(lines, {"b": b"lost"}, {"lost": b"lost"})
    except JournalError:
        _no_blob(journal, "lost")
        return
    positions = [line.position for line in lines]
    raise ContractBroken(f"positions {positions} do not follow {journal.last}; the commit must raise JournalError")


def _no_blob(journal: Journal, name: str) -> None:
    try:
        journal.blob(name)
    except JournalError:
        return
    raise ContractBroken(f"there is no blob {name!r}; asking for it must raise JournalError")
