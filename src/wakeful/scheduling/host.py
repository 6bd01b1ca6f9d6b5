"""What scheduling needs of whoever hosts it: the kernel, or a journal at rest."""

from __future__ import annotations

from typing import Protocol

from wakeful.contracts.treatment import Treatment
from wakeful.facts.asking import Episode, Query, Reply
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.facts.inputs import Call
from wakeful.facts.lines import AnyRecord, Concluded
from wakeful.facts.settings import MindSettings


class Host(Protocol):
    """What the scheduler needs of the kernel."""

    settings: MindSettings

    @property
    def now_ns(self) -> int: ...
    def write(self, record: AnyRecord) -> None: ...
    def event(self, identity: str) -> Event: ...
    def call(self, call: Call) -> None: ...
    def recall(self, query: Query) -> tuple[Episode, ...]: ...
    def closes_ns(self, arrived_ns: int) -> int: ...
    def counselled(self, decision: Decision, reply: Reply) -> dict[str, float]: ...
    def concluded(self, record: Concluded) -> None: ...
    def note(self, what: str, detail: str, process: int = 0, event: str = "") -> None: ...


class Treatments(Protocol):
    """Where treatments are found by name."""

    def get(self, name: str) -> Treatment: ...
