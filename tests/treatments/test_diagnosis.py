import msgspec
import pytest

from tests.treatments.worlds import BARE, DOMAIN, NOW_S, episode, event, script
from wakeful.facts.domain import DomainSpec, EvidenceSource, Fault
from wakeful.facts.evidence import Evidence
from wakeful.facts.time import to_ns
from wakeful.testing import ScriptedMind, check_treatment
from wakeful.treatments.decorator import treatment
from wakeful.treatments.diagnosis import Diagnosis, DiagnosisSettings, diagnose, diagnosis


def heat(after_s: float, value: bytes, id: str = "h") -> Evidence:
    return Evidence(id=id, topic="heat", key="arm/temperature_J3", at_ns=to_ns(NOW_S + after_s), value=msgspec.Raw(value))


def diagnosed(mind: ScriptedMind, **fields: object) -> Diagnosis:
    result = mind.run(diagnosis, event(**fields))  # type: ignore[arg-type]
    assert isinstance(result, Diagnosis)
    return result


def test_the_suspects_are_ranked_by_what_explains_the_signs() -> None:
    result = diagnosed(ScriptedMind(DOMAIN, "auto", script()), state="unstable")
    assert result.suspects[0].fault == "collision"
    assert result.suspects[0].shown == ("current_high", "state=unstable")
    assert result.findings == {"current_high": True, "state=unstable": True}
    assert "collision" in result.says
    assert result.confidence == pytest.approx(result.suspects[0].posterior, abs=1e-3)


def test_in_auto_mode_it_names_the_next_check_and_waits_for_nothing() -> None:
    mind = ScriptedMind(DOMAIN, "auto", script(evidence=(heat(1.0, b"80.0"),)))
    result = diagnosed(mind)
    assert result.next_check is not None
    assert result.asked == ()
    assert "evidence" not in {each.request.kind for each in mind.exchanges}


def test_it_waits_for_the_reading_that_tells_most_and_goes_on_where_it_was() -> None:
    before = diagnosed(ScriptedMind(DOMAIN, "auto", script()))
    mind = ScriptedMind(DOMAIN, "delib", script(evidence=(heat(3.0, b"80.0"),)))
    result = diagnosed(mind)
    assert result.asked == ("temperature_c>70",)
    assert result.findings["temperature_c>70"] is True
    assert result.heard == (f"evidence heat/arm/temperature_J3 at {to_ns(NOW_S + 3.0)}: temperature 80 °C",)
    gears = [next(s.posterior for s in each.suspects if s.fault == "worn gear") for each in (before, result)]
    assert gears[1] > gears[0]
    assert mind.now_s == NOW_S + 3.0


def test_a_reading_that_denies_the_symptom_speaks_against_the_fault() -> None:
    result = diagnosed(ScriptedMind(DOMAIN, "delib", script(evidence=(heat(3.0, b'{"mean": 41.5}'),))))
    assert result.findings["temperature_c>70"] is False
    gear = next(suspect for suspect in result.suspects if suspect.fault == "worn gear")
    assert gear.missing == ("temperature_c>70",)


def test_without_the_reading_it_stops_at_half_the_outcome_window_and_says_what_is_missing() -> None:
    mind = ScriptedMind(DOMAIN, "delib", script())
    result = diagnosed(mind)
    assert mind.now_s == NOW_S + DOMAIN.outcome.within_s / 2
    assert result.heard == ()
    assert any("temperature > 70 °C" in each for each in result.would_change)


def test_a_deadline_that_leaves_no_time_for_a_reading_is_not_spent_on_waiting() -> None:
    mind = ScriptedMind(DOMAIN, "delib", script())
    mind.run(diagnosis, event(deadline_s=3.0))
    assert mind.now_s == NOW_S


def test_other_signs_of_the_same_robot_while_it_waited_count_as_symptoms() -> None:
    told = script(episode("e1", 20.0, kind="stop", entity="cell"))
    result = diagnosed(ScriptedMind(DOMAIN, "auto", told))
    assert result.findings["stop"] is True
    assert "event e1" in result.rests_on
    old = script(episode("e1", 70.0, kind="stop", entity="cell"))
    assert "stop" not in diagnosed(ScriptedMind(DOMAIN, "auto", old)).findings


def test_a_settled_diagnosis_proposes_its_remedy_with_preconditions_and_an_end() -> None:
    @treatment("diagnosis", result=Diagnosis, says="a bolder one")
    async def bold(event, mind):  # type: ignore[no-untyped-def]
        return await diagnose(event, mind, DiagnosisSettings(threshold=0.5))

    result = check_treatment(bold, event(state="unstable"), DOMAIN, script())["delib"]
    assert isinstance(result, Diagnosis)
    assert result.settled
    [proposal] = result.proposes
    assert proposal.effect == "clear"
    assert proposal.preconditions == ("checked: look", "J3 is safe to work on")
    assert proposal.valid_until_ns == to_ns(NOW_S + 60.0)


def test_without_a_fault_table_it_says_that_it_can_make_no_diagnosis() -> None:
    result = diagnosed(ScriptedMind(BARE, "delib", script()))
    assert "no fault table" in result.says
    assert result.suspects == ()
    assert result.confidence == 0.1


def test_a_fault_table_that_names_outcomes_forecasts_them() -> None:
    quiet, worn = (diagnosed(ScriptedMind(DOMAIN, "auto", script()), temperature_c=value).forecast for value in (20.0, 90.0))
    assert quiet is not None
    assert worn is not None
    assert worn.probabilities["stop"] > quiet.probabilities["stop"]


def test_one_reading_with_several_values_answers_every_symptom_that_it_tells_of() -> None:
    faults = (
        Fault(name="stalled", prior=0.05, causes={"state=abnormal": 0.8, "current_a=>6": 0.9, "temperature_c=>70": 0.2}),
        Fault(name="hot", prior=0.05, causes={"state=abnormal": 0.8, "temperature_c=>70": 0.9}),
    )
    offers = (EvidenceSource(topic="reading", channels=(), every_s=5.0, fields=("temperature_c", "current_a")),)
    domain = DomainSpec(name="d", version=1, says="d", fault=faults, evidence=offers)
    told = Evidence(
        id="r",
        topic="reading",
        key="pump",
        at_ns=to_ns(NOW_S + 9.0),
        value=msgspec.Raw(b'{"temperature_c": 52, "current_a": 9.1}'),
    )
    mind = ScriptedMind(domain, "delib", script(evidence=(told,)))
    result = mind.run(diagnosis, event("object", "pump", state="abnormal"))
    assert isinstance(result, Diagnosis)
    assert result.findings == {"state=abnormal": True, "current_a=>6": True, "temperature_c=>70": False}
    assert len(result.asked) == 1
    assert result.suspects[0].fault == "stalled"


def test_a_fault_that_explains_only_what_happened_near_it_is_not_named_as_this_events_fault() -> None:
    told = script(episode("e1", 10.0, kind="stop", entity="cell"), episode("e2", 12.0, kind="current_high", entity="J1"))
    result = ScriptedMind(DOMAIN, "auto", told).run(diagnosis, event("door_open", "door"))
    assert isinstance(result, Diagnosis)
    assert not any(suspect.explains for suspect in result.suspects)
    assert "no fault of the table explains it; signs near it (current high, stop) point to worn gear" in result.says
    assert result.confidence == 0.1


def test_the_words_of_an_error_say_more_than_what_kind_of_error_it_is() -> None:
    faults = (
        Fault(name="blocked wheel", prior=0.04, causes={"stall": 0.8, "about=drive": 0.4, "text~wheel|jam": 0.7}),
        Fault(name="overheated drive", prior=0.05, causes={"about=drive": 0.8, "text~temperature|overheat": 0.9}),
    )
    domain = DomainSpec(name="fleet", version=1, says="", fault=faults)
    for text, cause in (("driveOvertemperature: above 85 °C", "overheated drive"), ("Wheel jammed", "blocked wheel")):
        found = event("error", about="drive", text=text)
        result = ScriptedMind(domain, "auto", script(episode("s", 5.0, "stall"))).run(diagnosis, found)
        assert isinstance(result, Diagnosis)
        assert result.suspects[0].fault == cause
        assert result.suspects[0].posterior > 0.8


def test_words_that_nobody_said_are_nothing_to_look_for() -> None:
    fault = Fault(name="weak radio", prior=0.3, causes={"silence": 0.6, "text~wifi|signal": 0.9, "about=network": 0.5})
    domain = DomainSpec(name="fleet", version=1, says="", fault=(fault,))
    result = ScriptedMind(domain, "auto", script()).run(diagnosis, event("silence"))
    assert isinstance(result, Diagnosis)
    assert result.next_check is not None
    assert result.next_check.symptom == "about=network"
