"""One validated experience suffices, one contradiction stops: reason → validate → reuse → contradicted → reason → reuse, live."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from wakeful.contracts.detector import DetectorFactory
from wakeful.deliberation.scripted import ScriptedReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import DomainSpec, FieldSpec, OutcomeSpec
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import AnyRecord, Concluded, Decided, Gained
from wakeful.facts.time import NS_PER_S
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit

START_NS = 1_700_000_000 * NS_PER_S
APART_S, OUTCOME_S = 100, 40


class Gates:
    """A world of gates: what comes of one is told, and no model ever gets enough to learn from."""

    spec = DomainSpec(
        name="gates",
        version=1,
        says="Gates that are open or stuck.",
        treatments=("description",),
        fields={"gate": FieldSpec(values=("open", "stuck")), "load": FieldSpec(low=0.0, high=1.0)},
        outcome=OutcomeSpec(labels=("none", "intervention"), within_s=60.0, scope="entity"),
    )

    def detectors(self) -> dict[str, DetectorFactory]:
        return {}

    def simulate(self, seed: int) -> None:
        return None


def lived(outcomes: str, gates: str = "", says: str = "") -> MemoryJournal:
    """A mind that met one event after the other: ``n`` none, ``i`` intervention came of it. The reasoner forecasts ``says``."""
    forecasts: Iterator[str] = iter(says or outcomes)

    def rule(question: Question) -> Reply:
        label = {"n": "none", "i": "intervention"}[next(forecasts)]
        return Reply(choice="description", confidence=0.9, forecast=label, forecast_probability=0.9)

    items: list[Draft | Outcome] = []
    for number, outcome in enumerate(outcomes):
        at_ns = START_NS + number * APART_S * NS_PER_S
        gate = "stuck" if gates[number : number + 1] == "s" else "open"
        fields = {"gate": gate, "load": 0.5}
        items.append(Draft(kind="gate", entity="gate", source="made", position=2 * number, at_ns=at_ns, fields=fields))
        label = "none" if outcome == "n" else "intervention"
        items.append(Outcome(id=f"o{number}", topic="outcome", entity="gate", label=label, at_ns=at_ns + OUTCOME_S * NS_PER_S))
    kernel, learner = assemble(Gates())
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, ScriptedReasoner(rule), learner)
    for _ in driver.run("made", "digest", lambda after: iter(items[after + 1 :])):
        pass
    driver.close()
    return journal


def records(journal: MemoryJournal, kind: type[AnyRecord]) -> list:
    return [line.record for line in journal.lines() if isinstance(line.record, kind)]


def modes(journal: MemoryJournal) -> list[str]:
    return [record.mode for record in records(journal, Concluded)]


def forecasts(journal: MemoryJournal) -> list[str]:
    return [record.forecast.label for record in records(journal, Concluded)]


def test_what_was_validated_once_is_automatic_the_next_time() -> None:
    journal = lived("nn")
    first, second = modes(journal)
    assert first in ("delib", "fallback")
    assert second == "auto"
    decided = records(journal, Decided)[-1].decision
    assert decided.recalled == records(journal, Gained)[0].experience.id
    assert "Like experience 1" in decided.reasons[0]
    assert audit(journal).ok


def test_a_contradiction_stops_it_until_an_experience_that_ended_so_was_supported() -> None:
    """After validations that told the same the world changes: contradicted, deliberated, supported, automatic again."""
    journal = lived("nnnnnniiii", says="iii")
    made = modes(journal)
    assert made[0] in ("delib", "fallback")
    assert made[1:7] == ["auto"] * 6
    assert made[7:] == ["delib", "auto", "auto"]
    assert forecasts(journal)[6:] == ["none", "intervention", "intervention", "intervention"]
    verdicts = [record.experience.verdict for record in records(journal, Gained)]
    assert verdicts[6:] == [Verdict.CONTRADICTED, Verdict.SUPPORTED, Verdict.SUPPORTED, Verdict.SUPPORTED]
    assert "told otherwise" in " ".join(records(journal, Decided)[7].decision.reasons)
    assert audit(journal).ok


def test_another_event_is_not_touched_by_that_contradiction() -> None:
    journal = lived("nnnnnninn", gates="osososooss"[:9], says="nnnn")
    made = modes(journal)
    assert made[0] != "auto"
    assert made[1] != "auto"
    assert made[2:6] == ["auto"] * 4
    # The seventh, an open one, is contradicted; the stuck one goes on.
    assert made[8] == "auto"
    assert forecasts(journal)[8] == "none"


def test_unvalidated_experience_is_never_reused() -> None:
    journal = lived("n" * 3)
    gained = records(journal, Gained)
    assert all(record.decision.recalled in (0, *(each.experience.id for each in gained)) for record in records(journal, Decided))
    assert modes(journal)[0] != "auto"


@pytest.mark.parametrize("outcomes", ["nnnnnniii", "ninninin", "iiii"])
def test_a_mind_rebuilt_from_its_journal_decides_the_same(outcomes: str) -> None:
    journal = lived(outcomes)
    lines = list(journal.lines())
    again, _ = assemble(Gates())
    again.recover(lines, journal.state(), {})
    whole, _ = assemble(Gates())
    whole.recover(lines, journal.state(), {})
    drafts = [
        Draft(kind="gate", entity="gate", source="made", position=999, at_ns=again.now_ns, fields={"gate": "open", "load": 0.5})
    ]
    assert again.feed(drafts, again.now_ns).lines == whole.feed(drafts, whole.now_ns).lines
