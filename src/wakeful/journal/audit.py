"""The audit: walk a journal in the order of its lines and prove, or refute, what wakeful promises."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol, runtime_checkable

from wakeful.facts.lines import Line
from wakeful.journal.checks.check import Check, Offence
from wakeful.journal.checks.decisions import Gates, Trust
from wakeful.journal.checks.identities import Identities
from wakeful.journal.checks.intake import Abandoned, Conservation, Coverage
from wakeful.journal.checks.learned import Lineage, Weights
from wakeful.journal.checks.order import Positions, ReadableLines, Time
from wakeful.journal.checks.processes import Results, Transitions, Wakeups
from wakeful.journal.checks.requests import Answers, Repeats
from wakeful.journal.checks.verdicts import Verdicts
from wakeful.journal.checks.whole import Offered, Whole
from wakeful.journal.readable import Readable, View

#: The checks, in the order of the report. To add one is to write it and name it here.
CHECKS: tuple[type[Check], ...] = (
    Positions,
    Time,
    Conservation,
    Identities,
    Coverage,
    Abandoned,
    Transitions,
    Results,
    Wakeups,
    Answers,
    Repeats,
    Gates,
    Verdicts,
    Trust,
    Lineage,
)


@runtime_checkable
class _WithBlobs(Protocol):
    """A journal that keeps weights beside its lines, as every Journal does; a bare sequence of lines has none."""

    def blob(self, name: str) -> bytes: ...


@runtime_checkable
class _WithState(Protocol):
    """A journal that keeps state beside its lines, as every Journal does."""

    def state(self) -> dict[str, bytes]: ...


@runtime_checkable
class _WithCommits(Protocol):
    """A journal on disk, which other processes may write meanwhile, and which says what each commit added."""

    def snapshot(self) -> AbstractContextManager[None]: ...

    def commits(self) -> Iterator[int]: ...


class Finding(View, frozen=True):
    """What one check found. ``count`` is of offences, ``checked`` of what the rule was put to, ``skipped`` why to nothing."""

    ok: bool
    count: int
    checked: int
    says: str
    first_offender: Offence | None = None
    skipped: str = ""


class Audit(View, frozen=True):
    """The whole report: ``ok`` when every check is."""

    ok: bool
    lines: int
    checks: dict[str, Finding]

    @property
    def first_offender(self) -> Offence | None:
        """The offence that stands first in the journal."""
        offences = [finding.first_offender for finding in self.checks.values() if finding.first_offender]
        return min(offences, key=lambda offence: offence.position, default=None)


def audit(journal: Readable) -> Audit:
    """Walk a journal once and put every check to it.

    A rule that holds only once a commit is whole is put each time kernel time goes on, and at the end. What stands after a line
    that cannot be read is not looked at: the report says where that is.

    Args:
        journal: any journal; a running one is audited up to its last committed line.

    Returns:
        the report. Nothing is raised on a journal that is wrong: that is what the report is for.
    """
    with journal.snapshot() if isinstance(journal, _WithCommits) else nullcontext():
        return _audit(journal)


def _audit(journal: Readable) -> Audit:
    readable = ReadableLines()
    checks = [make() for make in CHECKS]
    if isinstance(journal, _WithBlobs):
        checks.append(Weights(journal.blob))
    if isinstance(journal, _WithState):
        checks.append(Offered(journal.state))
    if isinstance(journal, _WithCommits):
        checks.append(Whole(journal.commits()))
    last: Line | None = None
    lines = 0
    for line in readable.of(journal):
        if last is not None and line.at_ns != last.at_ns:
            for check in checks:
                check.settle()
        for check in checks:
            check.see(line)
        last = line
        lines += 1
    if not readable.offences:
        for check in checks:
            check.settle()
            check.end()
    checks.insert(0, readable)
    return Audit(
        ok=not any(check.offences for check in checks),
        lines=lines,
        checks={
            check.name: Finding(
                ok=not check.offences,
                count=check.offences,
                checked=check.checked,
                says=check.says,
                first_offender=check.first,
                skipped=check.skipped,
            )
            for check in checks
        },
    )
