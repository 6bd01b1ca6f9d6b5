"""`wakeful guarantee` and the gate in `wakeful why`, on journals that a run wrote."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.cli.conftest import Wakeful, written
from wakeful.cli.main import main
from wakeful.drivers.assembly import assemble
from wakeful.facts.lines import Decided, Line, Published, Revoked
from wakeful.facts.settings import MindSettings
from wakeful.journal.sqlite import open_journal
from wakeful.selection.guarantee import Guarantee, GuaranteeSettings


@pytest.fixture(scope="module")
def guaranteed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run under the guarantee, with the promise so loose that a few hundred events are enough."""
    path = tmp_path_factory.mktemp("guarantee") / "journal.db"
    arguments = ["run", "service_robot", "--events", "560", "--gate", "guarantee", "--alpha", "0.3", "--delta", "0.3"]
    run = CliRunner().invoke(main, [*arguments, "--audit-rate", "0.5", "--journal", str(path), "--json"])
    assert run.exit_code == 0, run.output
    return path


def test_it_says_what_is_promised_and_what_the_promise_rests_on(guaranteed: Path, wakeful: Wakeful) -> None:
    told = json.loads(wakeful("guarantee", "--journal", guaranteed, "--json").stdout)
    assert told["under_guarantee"] is True
    assert (told["alpha"], told["delta"]) == (0.3, 0.3)
    rows = {row["treatment"]: row for row in told["treatments"]}
    held = [row for row in rows.values() if row["state"] == "certified"]
    assert held
    for row in held:
        assert row["bound"] <= 0.3
        assert row["automatic"] > 0
        assert row["drawn"] < row["events"]
        assert row["may_cost"] > 0
        assert 0.0 <= row["share_validated"] + row["share_never_validated"] <= 1.0
    text = wakeful("guarantee", "--journal", guaranteed).stdout
    assert "certified for scores from" in text
    assert "P(wrong and automatic)" in text


def test_the_drawn_events_that_await_their_outcome_are_listed(guaranteed: Path, wakeful: Wakeful) -> None:
    rows = json.loads(wakeful("guarantee", "--journal", guaranteed, "--awaiting", "--json").stdout)
    told = json.loads(wakeful("guarantee", "--journal", guaranteed, "--json").stdout)["treatments"]
    assert len(rows) <= sum(row["awaiting"] for row in told)
    text = wakeful("guarantee", "--journal", guaranteed, "--awaiting").stdout
    assert all(row["event"] in text for row in rows)
    assert text.strip()


def test_the_same_evidence_can_be_looked_at_for_a_stricter_promise(guaranteed: Path, wakeful: Wakeful) -> None:
    told = json.loads(wakeful("guarantee", "--journal", guaranteed, "--alpha", "0.01", "--json").stdout)
    assert {row["state"] for row in told["treatments"]} == {"not yet"}
    assert all(row["needed"] > 0 for row in told["treatments"])


def test_what_is_printed_is_what_the_mind_itself_holds(guaranteed: Path, wakeful: Wakeful) -> None:
    """Recovery and the command fold the same records."""
    settings = MindSettings(gate="guarantee", alpha=0.3, delta=0.3, audit_rate=0.5)
    kernel, _ = assemble("service_robot", settings)
    with open_journal(guaranteed, read_only=True) as journal:
        cards = [line.record.card for line in journal.lines_of(kinds=("published",)) if isinstance(line.record, Published)]
        blobs = {card.blob: journal.blob(card.blob) for card in cards if card.accepted}
        kernel.recover(journal.lines(), {}, blobs)
    rows = json.loads(wakeful("guarantee", "--journal", guaranteed, "--json").stdout)["treatments"]
    held = kernel._guarantee
    assert held is not None
    assert {
        row["treatment"]: (1.01 if row["level"] is None else row["level"], row["events"], row["automatic"]) for row in rows
    } == {name: (one.level, one.events, one.counted.automatic) for name, one in held.standings.items()}


def test_why_says_the_gates_state_in_words(guaranteed: Path, wakeful: Wakeful) -> None:
    with open_journal(guaranteed, read_only=True) as journal:
        made = [line.record for line in journal.lines_of(kinds=("decided",)) if isinstance(line.record, Decided)]
    automatic = next(record for record in made if record.decision.audit is not None and record.decision.audit.automatic)
    waiting = next(record for record in made if record.decision.audit is not None and record.decision.audit.level > 1)
    said = " ".join(wakeful("why", automatic.event, "--journal", guaranteed).stdout.split())
    assert "from which a risk of 30 % is certified" in said
    said = " ".join(wakeful("why", waiting.event, "--journal", guaranteed).stdout.split())
    assert "no the treatment is certified at a risk of 30 %: not yet, so every outcome counts as evidence" in said


def test_a_revoked_certificate_is_told_with_its_reason(tmp_path: Path, wakeful: Wakeful, guaranteed: Path) -> None:
    with open_journal(guaranteed, read_only=True) as journal:
        lines = list(journal.lines())
    gate = Guarantee(GuaranteeSettings(alpha=0.3, delta=0.3, audit_rate=0.5))
    for line in lines:
        gate.apply(line.record)
    name, held = next((name, one) for name, one in gate.standings.items() if one.certificate is not None)
    revoked = Revoked(treatment=name, model=held.model, number=held.number, why="audited answers were wrong too often")
    path = written([*lines, Line(lines[-1].position + 1, lines[-1].at_ns, revoked)], tmp_path / "revoked.db")
    text = wakeful("guarantee", "--journal", path).stdout
    assert f"{name}: revoked, audited answers were wrong too often" in " ".join(text.split())
    rows = json.loads(wakeful("guarantee", "--journal", path, "--json").stdout)["treatments"]
    assert next(row for row in rows if row["treatment"] == name)["state"] == "revoked"


def test_a_journal_of_another_gate_is_promised_nothing(journal: Path, wakeful: Wakeful) -> None:
    told = wakeful("guarantee", "--journal", journal)
    assert told.exit_code == 0
    assert "nothing is promised" in told.stdout
    assert json.loads(wakeful("guarantee", "--journal", journal, "--json").stdout)["under_guarantee"] is False
