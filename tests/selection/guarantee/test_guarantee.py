"""The guarantee gate from records to certificates and back: what counts, what does not, and that it is a fold."""

from __future__ import annotations

import msgspec
import pytest

from wakeful.facts.decisions import Candidate, Decision, Gate
from wakeful.facts.evidence import Origin, Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import AnyRecord, Certified, Concluded, Created, Decided, Judged, Moved, Revoked, Witnessed
from wakeful.facts.processes import State, Trigger
from wakeful.facts.settings import MindSettings
from wakeful.facts.values import NOTHING as NO_JSON
from wakeful.selection.guarantee import Guarantee, GuaranteeSettings, guarantee_of
from wakeful.selection.guarantee.standing import NOTHING, Standing

GATE = Gate(confidence=0.99, threshold=0.9, novelty=0.1, novelty_limit=0.99, trust=1.0, trust_limit=0.4)
RATE = 0.5


class Life:
    """A gate, and the records of the events that it lives through."""

    def __init__(self, **settings: object) -> None:
        self.gate = Guarantee(msgspec.convert({"audit_rate": RATE, "seek_from": 20, **settings}, GuaranteeSettings))
        self.records: list[AnyRecord] = []
        self.process = 0

    def write(self, record: AnyRecord) -> None:
        self.records.append(record)
        self.gate.apply(record)
        for change in self.gate.changes():
            self.records.append(change)
            self.gate.apply(change)

    def decide(
        self, score: float = 0.995, model: int = 1, reopens: int = 0, watermark: int = 20, made: dict[str, object] | None = None
    ) -> int:
        """An event that the model decides on, and its process."""
        self.process += 1
        audit = self.gate.rule(f"event {self.process}", "memory", "none", model, score)
        decision = Decision(
            treatment="memory",
            mode="auto" if audit.automatic else "delib",
            confidence=0.99,
            candidates=(Candidate(treatment="memory", probability=0.99),),
            reasons=(),
            gate=GATE,
            prior={"none": 0.9, "fall": 0.1},
            model=model,
            watermark=watermark,
            audit=audit,
        )
        decision = msgspec.structs.replace(decision, **(made or {}))
        event = f"event {self.process}"
        self.write(Created(process=self.process, event=event, treatment="memory", criticality=0, reopens=reopens))
        self.write(Decided(process=self.process, event=event, decision=decision))
        return self.process

    def conclude(self, process: int, mode: str = "auto", window: bool = True) -> None:
        self.write(
            Concluded(
                process=process,
                event=f"event {process}",
                treatment="memory",
                mode=mode,
                result=NO_JSON,
                closes_ns=1 if window else None,
            )
        )
        self.write(Moved(process=process, before=State.ACTIVE, trigger=Trigger.RESOLVE, after=State.COMPLETED))

    def judge(self, process: int, label: str, verdict: Verdict | None = None, told: str = "", origin: Origin = "world") -> None:
        """The world shows a label; the result had forecast ``none``."""
        outcome = Outcome(id=f"o{process}", topic="o", entity="*", label=label, at_ns=0, treatment=told, origin=origin)
        self.write(Witnessed(outcome=outcome))
        seen = verdict or (Verdict.SUPPORTED if label == "none" else Verdict.CONTRADICTED)
        self.write(
            Judged(
                process=process,
                event=f"event {process}",
                predicted="none",
                label=label,
                verdict=seen,
                outcome=outcome.id,
            )
        )

    def live(self, events: int, label: str = "none", **how: object) -> None:
        for _ in range(events):
            process = self.decide()
            self.conclude(process, "auto" if self.standing.certificate else "delib")
            self.judge(process, label, **how)  # type: ignore[arg-type]

    @property
    def standing(self) -> Standing:
        return self.gate.standings["memory"]

    def of(self, kind: type) -> list[AnyRecord]:
        return [record for record in self.records if isinstance(record, kind)]


def test_a_treatment_is_certified_once_enough_outcomes_were_right_and_not_one_earlier() -> None:
    life = Life()
    life.decide()
    needed = life.standing.needed
    assert needed > 59, "looked at after every outcome, more are needed than in a sample of fixed size"
    life = Life()
    life.live(needed - 1)
    assert life.standing.level == NOTHING
    assert life.standing.needed == 1
    life.live(1)
    [*_, certified] = life.of(Certified)
    assert isinstance(certified, Certified)
    assert certified.bound <= 0.05
    assert (certified.events, certified.drawn, certified.errors) == (needed, needed, 0)
    assert life.gate.rule("next", "memory", "none", 1, 0.995).automatic
    assert not life.gate.rule("next", "planning", "none", 1, 0.995).automatic


def test_before_the_certificate_every_event_is_drawn_and_after_it_as_many_as_the_rate_says() -> None:
    life = Life()
    life.live(100)
    before, after = life.gate.rule("x", "memory", "none", 2, 0.995), life.gate.rule("x", "memory", "none", 1, 0.995)
    assert (before.probability, before.drawn, before.automatic) == (1.0, True, False)
    assert after.probability == RATE
    assert after.automatic


def test_only_what_the_score_reaches_is_certified() -> None:
    life = Life()
    for number in range(150):
        process = life.decide(score=0.995 if number % 2 else 0.65)
        life.conclude(process, "delib")
        life.judge(process, "none" if number % 2 or number % 4 else "fall")
    level = life.standing.level
    assert 0.65 < level <= 0.99
    assert life.gate.rule("x", "memory", "none", 1, 0.995).automatic
    assert not life.gate.rule("x", "memory", "none", 1, 0.65).automatic


@pytest.mark.parametrize(
    ("how", "wrong"),
    [
        ({"label": "fall"}, True),
        ({"label": "none", "told": "planning"}, True),
        ({"label": "none", "told": "memory"}, False),
        ({"label": "none", "origin": "person"}, False),
        ({"label": "none", "origin": "reasoner"}, True),
        ({"label": "none", "verdict": Verdict.UNDECIDED}, True),
    ],
)
def test_what_counts_against_a_treatment(how: dict[str, object], wrong: bool) -> None:
    """A wrong result, a wrong treatment, and whatever neither the world nor a person has decided."""
    life = Life()
    life.live(1, **how)  # type: ignore[arg-type]
    assert (life.standing.events, life.standing.errors_now) == (1, int(wrong))


def test_what_is_undecided_is_left_out_where_the_settings_say_so() -> None:
    life = Life(unknown="left out")
    life.live(1, verdict=Verdict.UNDECIDED)
    assert life.standing.events == 0
    assert life.standing.counted.unknown == 1


def test_a_result_that_nobody_can_judge_is_unknown_and_counts_against_it() -> None:
    life = Life()
    life.conclude(life.decide(), window=False)
    assert (life.standing.events, life.standing.errors_now, life.standing.counted.unknown) == (1, 1, 1)


def test_a_deliberated_event_is_judged_by_what_the_model_had_answered() -> None:
    """The reasoner forecast the fall and was right; the model's own answer was that nothing would come."""
    life = Life()
    process = life.decide()
    life.conclude(process, "delib")
    life.judge(process, "fall", Verdict.SUPPORTED)
    assert life.standing.errors_now == 1


def test_outcomes_count_in_the_order_of_decisions() -> None:
    life = Life()
    first, second = life.decide(), life.decide()
    life.conclude(first, "delib")
    life.conclude(second, "delib")
    life.judge(second, "fall")
    assert life.standing.events == 0
    life.judge(first, "none")
    assert (life.standing.events, life.standing.errors_now) == (2, 1)


def test_a_reopened_or_second_decision_is_no_further_evidence() -> None:
    life = Life()
    process = life.decide(reopens=7)
    life.conclude(process, "delib")
    life.judge(process, "none")
    assert "memory" not in life.gate.standings


def test_a_model_that_has_learned_from_little_is_not_put_to_the_test() -> None:
    life = Life()
    life.decide(watermark=19)
    assert "memory" not in life.gate.standings


def test_another_model_version_must_earn_its_own_certificate() -> None:
    life = Life()
    life.live(120)
    assert life.standing.certificate is not None
    late = life.decide()
    life.decide(model=2)
    assert life.standing.certificate is None
    assert (life.standing.number, life.standing.events) == (2, 0)
    life.conclude(late)
    life.judge(late, "fall")
    assert life.standing.errors_now == 0, "an answer of the version before is no evidence on this one"
    assert life.standing.counted.wrong == 1


def test_errors_that_come_too_fast_revoke_the_certificate_and_the_next_one_must_be_earned_anew() -> None:
    life = Life()
    life.live(100)
    assert life.standing.certificate is not None
    life.live(8, "fall")
    [revoked] = life.of(Revoked)
    assert isinstance(revoked, Revoked)
    assert "wrong more often" in revoked.why
    assert life.standing.level == NOTHING
    assert life.standing.number == 2
    assert life.standing.events < 8
    assert not life.gate.rule("next", "memory", "none", 1, 0.995).automatic
    before = len(life.of(Certified))
    life.live(450)
    assert len(life.of(Certified)) > before
    [*_, again] = life.of(Certified)
    assert isinstance(again, Certified)
    assert again.number == 2
    assert again.delta < 0.05 / 2


def test_a_reasoners_disagreement_may_revoke_and_its_consent_certifies_nothing() -> None:
    life = Life(audit_rate=1.0, audit_by="deliberation")
    life.live(100)
    assert life.standing.certificate is not None
    for _ in range(5):
        process = life.decide()
        decided = life.records[-1]
        assert isinstance(decided, Decided)
        otherwise = msgspec.structs.replace(decided.decision, treatment="planning")
        life.write(msgspec.structs.replace(decided, decision=otherwise))
        if life.of(Revoked):
            break
        assert life.standing.doubted == process - 100
    else:
        pytest.fail("it was not revoked")
    [revoked] = life.of(Revoked)
    assert isinstance(revoked, Revoked)
    assert "a reasoner answered" in revoked.why
    before = life.standing.events
    agreed = life.decide()
    life.write(life.records[-1])
    life.conclude(agreed, "delib")
    assert life.standing.events == before


def test_an_undrawn_error_is_seen_by_the_watch_and_supports_no_bound() -> None:
    life = Life(audit_rate=0.001)
    life.live(100)
    errors = life.standing.errors_now
    life.live(3, "fall")
    assert life.standing.errors_now == errors
    assert float(life.standing.evidence.seen) > float(life.standing.evidence.audited)


def test_a_stricter_level_voids_the_certificate_that_stood() -> None:
    life = Life()
    life.live(100)
    stricter = Guarantee(GuaranteeSettings(alpha=0.01, audit_rate=RATE, seek_from=20))
    for record in life.records:
        stricter.apply(record)
    assert not stricter.rule("next", "memory", "none", 1, 0.995).automatic


def test_the_gate_is_the_fold_of_its_records() -> None:
    life = Life()
    life.live(100)
    life.live(8, "fall")
    life.live(120)
    pending = life.decide()
    again = Guarantee(life.gate.settings)
    for record in life.records:
        again.apply(record)
    assert again.changes() == []
    for gate in (life.gate, again):
        gate.apply(Concluded(process=pending, event="", treatment="memory", mode="auto", result=NO_JSON, closes_ns=1))
    assert _told(again) == _told(life.gate)
    scores = (0.3, 0.91, 0.995)
    assert [again.rule(f"e{i}", "memory", "none", 1, score) for i in range(20) for score in scores] == [
        life.gate.rule(f"e{i}", "memory", "none", 1, score) for i in range(20) for score in scores
    ]


def _told(gate: Guarantee) -> tuple[object, ...]:
    one = gate.standings["memory"]
    watches = float(one.evidence.audited), float(one.evidence.seen)
    return one.level, one.number, one.events, one.errors_now, one.bound, watches, one.counted


def test_the_drawn_automatic_events_that_await_an_outcome_are_told() -> None:
    life = Life(audit_rate=1.0)
    life.decide()
    assert life.gate.awaiting() == [], "what is not automatic is thought about anyway"
    life = Life(audit_rate=1.0)
    life.live(100)
    process = life.decide()
    assert life.gate.awaiting() == [(f"event {process}", "memory")]
    life.conclude(process)
    life.judge(process, "none")
    assert life.gate.awaiting() == []


def test_memory_may_stop_automation_but_neither_allow_it_nor_change_its_answer() -> None:
    gate = Guarantee(GuaranteeSettings())
    automatic = Decision(
        treatment="memory",
        mode="auto",
        confidence=0.9,
        candidates=(),
        reasons=(),
        gate=GATE,
        prior={"none": 0.9, "fall": 0.1},
    )
    stopped = msgspec.structs.replace(automatic, mode="delib")
    other = msgspec.structs.replace(automatic, treatment="planning")
    foretold = msgspec.structs.replace(automatic, prior={"none": 0.1, "fall": 0.9})
    assert gate.hold(automatic, automatic) is automatic
    assert gate.hold(automatic, stopped) is stopped
    for made in (other, foretold):
        assert gate.hold(automatic, made).mode == "delib"
    assert gate.hold(stopped, automatic).mode == "delib"


def test_evidence_is_on_the_models_own_answer_whatever_was_made_of_it() -> None:
    life = Life()
    process = life.decide(made={"treatment": "planning", "prior": {"none": 0.1, "fall": 0.9}})
    life.conclude(process, "delib")
    life.judge(process, "fall", Verdict.SUPPORTED)
    assert life.standing.errors_now == 1


def test_where_old_lines_were_given_up_a_certificate_stands_and_so_does_what_was_spent() -> None:
    life = Life()
    life.live(100)
    compacted = Guarantee(life.gate.settings)
    for record in [record for record in life.records if isinstance(record, Certified)]:
        compacted.apply(record)
    process = life.decide()
    for record in life.records[-2:]:
        compacted.apply(record)
    assert compacted.rule("next", "memory", "none", 1, 0.995).automatic
    assert compacted.changes() == []
    assert compacted.standings["memory"].bound <= 0.05
    life.conclude(process)
    life.judge(process, "fall")
    life.live(8, "fall")
    for record in life.of(Revoked):
        compacted.apply(record)
    assert compacted.standings["memory"].number == life.standing.number == 2
    assert not compacted.rule("next", "memory", "none", 1, 0.995).automatic


def test_under_another_gate_there_is_no_guarantee_and_settings_that_promise_nothing_are_refused() -> None:
    assert guarantee_of(MindSettings()) is None
    gate = guarantee_of(MindSettings(gate="guarantee", alpha=0.1, audit_rate=0.3))
    assert gate is not None
    assert (gate.settings.alpha, gate.settings.audit_rate) == (0.1, 0.3)
    for wrong in ({"alpha": 0.0}, {"delta": 1.0}, {"audit_rate": 0.0}, {"change": 1.0}, {"patience": 1.0}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            GuaranteeSettings(**wrong)
