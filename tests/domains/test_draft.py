"""A drafted domain loads, runs on the recording it was drafted from, and names what a person would look for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.bridges.xlsx import XlsxBridge
from wakeful.contracts.bridge import Peek
from wakeful.domains.draft import draft
from wakeful.domains.package import PackageDomain
from wakeful.domains.recognition import score
from wakeful.domains.survey import survey
from wakeful.domains.toml import parse_spec
from wakeful.facts.events import Observation
from wakeful.facts.values import Value
from wakeful.registration import SpecRegistrar

RECORDING = Path(__file__).parents[3] / "shared" / "data" / "ur3_cobotops" / "dataset.xlsx"


def recording() -> Iterator[Observation]:
    for position in range(600):
        at_ns = position * 100_000_000
        pulse = position % 60 == 50
        values: dict[str, Value] = {"seq": position, "part": position // 60, "effort": [1.0, 2.0], "state": {"mode": "AUTO"}}
        values |= {"force": 5.0 + (position * 7 % 13) / 13 + 20 * pulse, "pump_failed": pulse, "code": 3 if position > 300 else 0}
        yield Observation(source="dir/rig.csv", position=2 * position, topic="rig", at_ns=at_ns, values=values, robot="rig-1")
        said: dict[str, Value] = {"level": 40 if pulse else 20, "text": f"pump at {position * 1.5} bar in line {position % 3}"}
        said["errors"] = [{"errorType": "pressure", "errorLevel": "WARNING", "errorReferences": []}] if pulse else []
        yield Observation(source="dir/rig.csv", position=2 * position + 1, topic="/log", at_ns=at_ns, values=said, robot="rig-1")


def test_a_draft_proposes_what_the_channels_look_like() -> None:
    spec = parse_spec(draft(recording(), "My rig!", Peek("csv", ("rig/force",))), "draft")
    assert (spec.name, spec.robot, spec.recognise.bridges) == ("my_rig", "rig-1", ("csv",))
    assert spec.outcome.labels == ("none", "pump_failed")
    detectors = {(each.detector, channel) for each in spec.detect for channel in each.channels}
    assert {("band", "rig/force"), ("cycle", "rig/force"), ("edge", "rig/pump_failed"), ("edge", "rig/code")} <= detectors
    assert {("text", "/log/text"), ("conditions", "/log/errors"), ("silence", "rig/*")} <= detectors
    assert ("band", "rig/seq") not in detectors
    (listed,) = (each for each in spec.detect if each.detector == "conditions")
    assert listed.settings == {"type": "errorType", "level": "errorLevel", "references": "errorReferences"}


def test_a_draft_runs_on_its_recording_and_registers_its_incidents() -> None:
    text = draft(recording())
    registrar = SpecRegistrar(PackageDomain(parse_spec(text, "draft")), "d")
    registered = [registrar.observe(each) for each in recording()]
    kinds = Counter(event.kind for each in registered for event in each.events)
    assert sum(len(each.outcomes) for each in registered) == 10
    assert kinds["pump_failed"] == 10
    assert kinds["rig_changed"] == 1
    assert kinds["log_said"] >= 1
    assert kinds["errors_listed"] == 10
    assert sum(kinds.values()) < 100


def test_a_draft_recognises_its_own_recording_and_not_another() -> None:
    spec = parse_spec(draft(recording(), peek=Peek("csv", ())), "draft")
    own = Peek("csv", tuple(survey(recording()).channels))
    assert score(spec.recognise, own, Path("x.csv")) > 0
    assert score(spec.recognise, Peek("csv", ("other/x",)), Path("x.csv")) == 0


def test_a_recording_without_flags_says_what_is_missing() -> None:
    numbers = (Observation(source="s", position=p, topic="t", at_ns=p, values={"x": float(p % 7)}) for p in range(100))
    text = draft(numbers)
    assert "nothing learned; name a channel" in text
    assert parse_spec(text, "draft").outcome.labels == ("none", "intervention")


def test_an_empty_recording_gives_a_domain_that_loads() -> None:
    assert parse_spec(draft([]), "draft").detect[0].detector == "silence"


odd_names = st.text(max_size=6) | st.sampled_from(["a[0]", "*", "x.y", "{number}", "none", 'q"', "type", "level", "\x7f"])
odd_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(odd_names, inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(odd_names, st.dictionaries(odd_names, odd_values, max_size=5)), max_size=12), st.integers(1, 12))
def test_whatever_the_channels_are_called_the_draft_loads_and_runs(taken: list[tuple[str, dict[str, Value]]], times: int) -> None:
    observations = [
        Observation(source="s", position=position, topic=topic, at_ns=position * 10**9, values=values)
        for position, (topic, values) in enumerate(taken * times)
    ]
    registrar = SpecRegistrar(PackageDomain(parse_spec(draft(observations), "draft")), "d")
    for observation in observations:
        registrar.observe(observation)


@pytest.mark.skipif(not RECORDING.exists(), reason="needs ../shared/data/ur3_cobotops")
def test_a_draft_of_the_recorded_ur3_finds_its_cycle_and_both_outcomes() -> None:
    bridge = XlsxBridge()
    observations = [item for item in bridge.read(RECORDING) if isinstance(item, Observation)]
    spec = parse_spec(draft(observations, "arm", bridge.peek(RECORDING)), "draft")
    assert {source.channel for source in spec.outcomes} == {"row/Robot_ProtectiveStop", "row/grip_lost"}
    assert [each.settings["cycle"] for each in spec.detect if each.detector == "cycle"] == ["row/cycle"]
    registrar = SpecRegistrar(PackageDomain(spec), "d")
    events = [event for observation in observations for event in registrar.observe(observation).events]
    assert 185 < len(events) < len(observations) / 5
