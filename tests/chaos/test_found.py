"""What chaos found, each defect by itself: see docs/chaos.md."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import pytest

import wakeful
from wakeful.contracts.journal import JournalError
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.outside import LARGEST_REPLY_BYTES, make
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.drivers.spending import spent
from wakeful.facts.asking import Question, Reply
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.inputs import Act, Answer, Call
from wakeful.facts.lines import Answered, Line
from wakeful.facts.packs import Entry
from wakeful.facts.settings import MindSettings
from wakeful.facts.values import Field
from wakeful.journal import MemoryJournal, open_journal
from wakeful.journal.audit import audit
from wakeful.testing.crash_points import Crashed, crashing

QUESTION = Question(about="treatment", event="e", asks="which?", options=("description", "planning"), labels=("none", "trouble"))
RIGHT = Reply(
    choice="planning", confidence=0.9, forecast="none", forecast_probability=0.5, because=("so",), calls=2, cost_usd=0.1
)


class Says:
    """A reasoner of somebody else's, which checks nothing."""

    name = "says"
    latency_s = 0.0

    def __init__(self, reply: object) -> None:
        self.reply = reply

    async def answer(self, question: Question) -> Reply:
        return self.reply  # type: ignore[return-value]  # that is the fault


def answer_of(reply: object) -> Answer:
    call = Call(process=1, seq=1, asked_ns=0, expires_ns=1, question=QUESTION)
    return asyncio.run(make(call, Says(reply)))


def test_an_admissible_reply_comes_through_whole() -> None:
    answer = answer_of(RIGHT)
    assert not answer.error
    assert msgspec.json.decode(answer.value, type=Reply) == RIGHT


@pytest.mark.parametrize(
    "reply",
    [
        msgspec.structs.replace(RIGHT, confidence=float("nan")),
        msgspec.structs.replace(RIGHT, choice="launch_missiles"),
        msgspec.structs.replace(RIGHT, forecast="no such label"),
        msgspec.structs.replace(RIGHT, because=("so " * LARGEST_REPLY_BYTES,)),
    ],
    ids=["not a number", "unregistered treatment", "unknown label", "too long"],
)
def test_a_reasoner_without_checks_of_its_own_is_checked_and_what_it_cost_is_recorded(reply: Reply) -> None:
    answer = answer_of(reply)
    assert answer.error
    assert (answer.calls, answer.cost_usd) == (2, 0.1)


@pytest.mark.parametrize("reply", [None, {"choice": "planning"}, "planning"])
def test_what_is_no_reply_is_refused(reply: object) -> None:
    assert "not a Reply" in answer_of(reply).error


def a_mind(journal: MemoryJournal) -> SimulatedDriver:
    domain = load("service_robot")
    kernel, learner = assemble(domain, MindSettings(step_s=0.0))
    return SimulatedDriver(kernel, journal, Says(RIGHT), learner)


class FailsOnce(MemoryJournal):
    """Fails at its n-th commit, and at no other."""

    def __init__(self, nth: int) -> None:
        super().__init__()
        self.left = nth

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        self.left -= 1
        if self.left == 0:
            raise JournalError("for once")
        super().commit(lines, state, blobs)


def test_evidence_that_is_kept_outlives_a_commit_that_failed() -> None:
    journal = FailsOnce(3)  # the first two: what was recovered, and the beginning of the source
    driver = a_mind(journal)
    driver.begin("s", "d")
    early = Evidence(id="e1", topic="reading", key="pump", at_ns=0, value=msgspec.Raw(b'{"temperature_c": 80}'))
    with pytest.raises(JournalError):
        driver.put([early], 0)
    driver.close()  # commits what the failed commit left
    assert any(b"e1" in value for value in journal.state().values())


def test_a_live_mind_has_made_evidence_durable_when_it_says_so_although_nobody_waits_for_it() -> None:
    async def told() -> dict[str, bytes]:
        async with wakeful.open_live("service_robot") as mind:
            await mind.tell(Evidence(id="e1", topic="reading", key="pump", at_ns=0))
            return mind.journal.state()

    assert any(b'"e1"' in value for value in asyncio.run(told()).values())


def test_the_end_of_a_source_does_not_wait_for_an_answer_that_nobody_waits_for() -> None:
    thinker = Says(RIGHT)
    thinker.latency_s = 50.0
    domain = load("service_robot")
    kernel, learner = assemble(domain, MindSettings(step_s=0.0))
    driver = SimulatedDriver(kernel, MemoryJournal(), thinker, learner)
    unsteady: dict[str, Field] = {"category": "obstacle", "state": "unstable", "location": "edge"}
    met = Draft(kind="object", entity="box", source="s", position=0, at_ns=0, fields=unsteady)
    for _ in driver.run("s", "d", lambda after: [met][after + 1 :]):
        driver._feed([Act(who="ana", act="cancel", process=1, why="enough")], 1_000_000_000)
    assert kernel.now_ns == 1_000_000_000
    driver.close()


def test_the_opening_of_a_journal_that_is_interrupted_leaves_no_lock(tmp_path: Path) -> None:
    with crashing("journal: file made"), pytest.raises(Crashed):
        open_journal(tmp_path / "a.db")
    open_journal(tmp_path / "a.db").close()


def test_the_audit_takes_what_was_acted_on_as_validation_does(tmp_path: Path) -> None:
    path = tmp_path / "a.db"
    unsteady = {"category": "obstacle", "state": "unstable", "location": "edge"}
    calm = {"category": "item", "state": "normal", "location": "center"}
    with wakeful.Mind("service_robot", path) as mind:
        for entity, facts, label in (
            ("box", unsteady, "none"),
            ("crate", unsteady, "intervention"),
            ("mug", calm, "intervention"),
        ):
            event = mind.admit("object", entity, facts, at_ns=1_000_000_000).event
            concluded = mind.conclusion(event)
            assert concluded is not None
            assert concluded.forecast is not None
            came = Outcome(
                id=entity, topic="outcome", entity=entity, label=label, at_ns=2_000_000_000, event=event, acted_on=True
            )
            mind.tell(came)
    with open_journal(path) as journal:
        verdicts = [line.record.verdict for line in journal.lines_of(kinds=("judged",)) if hasattr(line.record, "verdict")]
        assert verdicts == ["undecided", "supported", "contradicted"]
        assert audit(journal).ok


def test_a_request_that_was_under_way_when_the_mind_ended_is_charged(tmp_path: Path) -> None:
    path = tmp_path / "a.db"
    facts = {"category": "obstacle", "state": "unstable", "location": "edge"}
    killed = wakeful.Mind("service_robot", path)
    with crashing("acting: call made"), pytest.raises(Crashed):
        killed.admit("object", "box", facts, at_ns=1_000_000_000)
    killed.journal.close()
    before = lines_of(path)
    assert not any(isinstance(line.record, Answered) and line.record.calls for line in before)
    assert spent(before, "guidelines").in_doubt == 1
    with wakeful.Mind("service_robot", path):
        pass  # it makes the call again: that is another
    after = spent(lines_of(path), "guidelines")
    assert after.in_doubt + after.calls == 2


def lines_of(path: Path) -> list[Line]:
    with open_journal(path, read_only=True) as journal:
        return list(journal.lines())
