"""One audit check: it sees the lines in order and names each that breaks its rule."""

from __future__ import annotations

from wakeful.facts.lines import Line
from wakeful.journal.readable import View


class Offence(View, frozen=True):
    """A line that breaks a rule: where it stands, which record it is, and what is wrong with it."""

    position: int
    record: str
    says: str


class Check:
    """The frame of a check. An author fills ``see``, and ``settle`` where a rule holds only once a commit is whole.

    ``name`` is what the report calls it, ``says`` the rule in one sentence. ``checked`` counts what the rule was put to,
    so that a check that found nothing to look at is told from one that looked; ``skipped`` says why it could not look at all.
    """

    name = ""
    says = ""

    def __init__(self) -> None:
        self.checked = 0
        self.offences = 0
        self.first: Offence | None = None
        self.skipped = ""

    def see(self, line: Line) -> None:
        """Look at one line."""

    def settle(self) -> None:
        """All records of one instant are in: the rules that hold between instants hold now."""

    def end(self) -> None:
        """All lines were read: what is put to the journal as a whole."""

    def offend(self, line: Line, says: str) -> None:
        """Count an offence; the first one is kept."""
        self.offences += 1
        if self.first is None:
            self.first = Offence(position=line.position, record=type(line.record).__name__.lower(), says=says)
