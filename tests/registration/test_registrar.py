"""The registrar: what becomes an event, what becomes evidence, and that a restart changes nothing."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.contracts.detector import DetectorFactory, Found, Offered, Shown
from wakeful.contracts.domain import DomainError, Registered
from wakeful.domains.package import PackageDomain
from wakeful.domains.toml import parse_spec
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase, Relation, event_id
from wakeful.facts.values import Value
from wakeful.registration import CLEARED, REPEATED, SpecRegistrar

EVERYTHING = """
name = "every"
version = 1
says = "every detector at once"
robot = "r1"
outcome = { labels = ["none", "stop"], within_s = 5.0 }
outcomes = [{ channel = "arm/stop", label = "stop", entity = "{robot}" }]
evidence = [{ topic = "load", channels = ["arm/J*"], key = "{name}", every_s = 2.0 }]
[fields]
load = { channel = "arm/J{number}", low = -2.0, high = 2.0 }
cycle_s = { since = "arm/cycle", high = 20.0 }
[[detect]]
detector = "band"
kind = "odd"
channels = ["arm/J*"]
entity = "J{number}"
settings = { learn = 5, gap_s = 0.0, calm = 1, lasting = true, cycle = "arm/cycle", phase_s = 4.0 }
[[detect]]
detector = "trend"
kind = "drift"
channels = ["arm/J*"]
settings = { window_s = 8.0, strength = 2.0 }
[[detect]]
detector = "threshold"
kind = "high"
channels = ["arm/J1"]
settings = { above = 3.0, below = -3.0, back = 1.0 }
[[detect]]
detector = "edge"
kind = "flag"
channels = ["arm/stop", "arm/mode"]
settings = { lasting = true }
[[detect]]
detector = "text"
kind = "said"
channels = ["log/text"]
settings = { again_s = 5.0 }
[[detect]]
detector = "silence"
kind = "silent"
channels = ["arm/*", "log/*"]
entity = "{topic}"
settings = { learn = 3, times = 2.0 }
[[detect]]
detector = "jump"
kind = "jump"
channels = ["arm/J*"]
settings = { learn = 4, times = 2.0, gap_s = 0.0 }
[[detect]]
detector = "conditions"
kind = "wrong"
channels = ["arm/errors"]
entity = "{robot}"
[[detect]]
detector = "cycle"
kind = "unlike"
channels = ["arm/J*"]
settings = { cycle = "arm/cycle", learn = 3, width = 1.0 }
[[detect]]
detector = "stall"
kind = "stall"
settings = { commanded = "arm/J0", measured = "arm/J1", hold_s = 1.0 }
"""


def registrar(toml: str = EVERYTHING, own: Mapping[str, DetectorFactory] | None = None) -> SpecRegistrar:
    return SpecRegistrar(PackageDomain(parse_spec(toml, "test.toml"), own or {}), "digest")


def seen(position: int, at_s: float, topic: str = "arm", **values: Value) -> Observation:
    return Observation(source="s", position=position, topic=topic, at_ns=round(at_s * 1e9), values=values)


class Scripted:
    """Finds what it is told to at each position."""

    def __init__(self, script: Mapping[int, list[Found | Shown | Offered]]) -> None:
        self.script = script

    def observe(self, observation: Observation) -> list[Found | Shown | Offered]:
        return list(self.script.get(observation.position, []))

    def state(self) -> bytes:
        return b""

    def restore(self, state: bytes) -> None:
        pass


def scripted(script: Mapping[int, list[Found | Shown | Offered]], more: str = "") -> SpecRegistrar:
    def made(spec: DetectorSpec, domain: DomainSpec) -> Scripted:
        del spec, domain
        return Scripted(script)

    toml = (
        'name = "own"\nversion = 1\nsays = ""\nrobot = "r1"\noutcome = { labels = ["none", "stop"] }\n'
        '[[detect]]\ndetector = "own"\nkind = "own"\n' + more
    )
    return registrar(toml, {"own": made})


junk = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.sampled_from([0.0, 1.0, 5.0, -4.0, 1e9]),
    st.text(max_size=8),
    st.lists(
        st.one_of(st.integers(), st.fixed_dictionaries({"type": st.sampled_from("ab"), "level": st.text(max_size=2)})), max_size=3
    ),
    st.dictionaries(st.sampled_from(["x", "J9"]), st.floats(), max_size=2),
)
names = st.sampled_from(["J0", "J1", "cycle", "stop", "mode", "errors", "text", "level", "other"])
steps = st.lists(
    st.tuples(
        st.sampled_from(["arm", "log", "elsewhere"]),
        st.one_of(st.sampled_from([0.0, 0.5, 1.0, 1.0, 7.0, -1.0, -500.0]), st.floats(-1e15, 1e15)),
        st.dictionaries(names, junk, max_size=6),
    ),
    min_size=1,
    max_size=60,
)


def stream(taken: list[tuple[str, float, dict[str, Value]]]) -> list[Observation]:
    at_s, made = 0.0, []
    for position, (topic, step_s, values) in enumerate(taken):
        at_s += step_s
        made.append(Observation(source="s", position=position, topic=topic, at_ns=round(at_s * 1e9), values=values))
    return made


@settings(max_examples=150, deadline=None)
@given(steps, st.lists(st.integers(0, 59), max_size=4))
def test_a_stream_cut_anywhere_goes_on_as_if_it_had_not_been(
    taken: list[tuple[str, float, dict[str, Value]]], cuts: list[int]
) -> None:
    observations = stream(taken)
    undisturbed, disturbed = registrar(), registrar()
    stored: dict[str, bytes] = {}
    for number, observation in enumerate(observations):
        if number in cuts:
            stored.update(disturbed.changed())
            disturbed = registrar()
            disturbed.restore(stored)
        assert disturbed.observe(observation) == undisturbed.observe(observation)
    stored.update(disturbed.changed())
    whole: dict[str, bytes] = undisturbed.changed()
    assert {name: part for name, part in stored.items() if name in whole} == whole


@settings(max_examples=100, deadline=None)
@given(steps)
def test_whatever_comes_the_events_can_be_written_down_and_numbers_are_finite(
    taken: list[tuple[str, float, dict[str, Value]]],
) -> None:
    mind = registrar()
    for observation in stream(taken):
        for draft in mind.observe(observation).events:
            for value in (*draft.fields.values(), *draft.context.fields.values()):
                assert not isinstance(value, float) or math.isfinite(value)
            assert draft.observations >= 1


def test_only_the_parts_that_changed_are_given_out() -> None:
    mind = registrar()
    mind.observe(seen(0, 0.0, J0=1.0))
    first = mind.changed()
    assert any(name.startswith("detect/0/band") for name in first)
    assert mind.changed() == {}
    mind.observe(seen(1, 1.0, "elsewhere", unheard=1.0))
    again = mind.changed()
    assert not any("band" in name for name in again)


def test_an_observation_nobody_looks_at_is_nothing() -> None:
    mind = scripted({}, 'channels = ["arm/*"]\n')
    assert mind.observe(seen(0, 0.0, "elsewhere", x=1)) is mind.observe(seen(1, 0.0, "elsewhere", x=2))


def test_relation_to_what_was_remembered_is_computed() -> None:
    def found(**fields: Value) -> list[Found | Shown | Offered]:
        return [Found(fields=fields, entity="cup")]  # type: ignore[arg-type]

    script = {0: found(load=0.5), 1: found(load=0.51), 2: found(load=0.9), 3: found(load=0.9, x=1.0), 4: found(load=0.9, x=5.0)}
    mind = scripted(script)
    relations = [mind.observe(seen(position, position)).events[0].relation for position in range(5)]
    assert relations == [Relation.NEW, Relation.UNCHANGED, Relation.CHANGED, Relation.CHANGED, Relation.MOVED]


def test_another_zone_is_a_move_and_the_last_zone_is_remembered() -> None:
    script = {position: [Found(fields={}, entity="cup", zone=zone)] for position, zone in enumerate(["shelf", "", "table"])}
    events = [
        scripted_event for mind in [scripted(script)] for p in range(3) for scripted_event in mind.observe(seen(p, p)).events
    ]
    assert [event.relation for event in events] == [Relation.NEW, Relation.UNCHANGED, Relation.MOVED]
    assert [event.context.zone for event in events] == ["shelf", "shelf", "table"]


def test_a_condition_is_one_event_then_evidence_until_it_is_cleared() -> None:
    def wrong(phase: Phase) -> list[Found | Shown | Offered]:
        return [Found(fields={"n": 1}, type="low|battery", references=("cell=3",), phase=phase)]

    phases = [Phase.RAISED, Phase.REPEATED, Phase.RAISED, Phase.CHANGED, Phase.CLEARED, Phase.CLEARED, Phase.REPEATED]
    mind = scripted({position: wrong(phase) for position, phase in enumerate(phases)})
    got = [mind.observe(seen(position, position)) for position in range(len(phases))]
    assert [[event.condition.phase for event in each.events if event.condition] for each in got] == [
        [Phase.RAISED], [], [], [Phase.CHANGED], [], [], [Phase.RAISED]
    ]  # fmt: skip
    key = "r1|s|low/battery|cell=3"
    assert got[0].events[0].condition is not None
    assert got[0].events[0].condition.key == key
    assert [[(item.topic, item.key) for item in each.evidence] for each in got] == [
        [], [(REPEATED, key)], [(REPEATED, key)], [], [(CLEARED, key)], [], []
    ]  # fmt: skip


def test_outcomes_and_evidence_have_ids_that_a_second_reading_repeats() -> None:
    script: dict[int, list[Found | Shown | Offered]] = {
        0: [Found(fields={}, entity="a"), Shown(label="stop", entity="a"), Offered(topic="t", key="k", value=[1, 2])],
        1: [Shown(label="stop", entity="a", event_position=0, treatment="memory")],
    }
    first, second = scripted(script), scripted(script)
    got = [first.observe(seen(position, position)) for position in (0, 1)]
    assert got == [second.observe(seen(position, position)) for position in (0, 1)]
    assert got[0].outcomes[0].id != got[1].outcomes[0].id
    assert bytes(got[0].evidence[0].value) == b"[1,2]"
    assert got[1].outcomes[0].event == event_id("r1", "digest", 0, "own", 0)
    assert got[1].outcomes[0].treatment == "memory"


def test_an_outcome_is_a_rising_edge_and_a_blank_neither_begins_nor_ends_one() -> None:
    mind = registrar()
    flags: list[Value] = [False, True, True, None, True, float("nan"), False, None, True]
    labels = [[outcome.label for outcome in mind.observe(seen(n, n, stop=flag)).outcomes] for n, flag in enumerate(flags)]
    assert labels == [[], ["stop"], [], [], [], [], [], [], ["stop"]]


def test_history_and_latest_values_stand_in_the_context() -> None:
    more = 'channels = ["arm/*"]\n[fields]\nload = { channel = "arm/J{number}" }\ncycle_s = { since = "arm/cycle" }\n'
    mind = scripted({p: [Found(fields={}, entity="J3")] for p in (1, 4)} | {2: [Shown(label="stop")]}, more)
    mind.observe(seen(0, 0.0, J3=7.5, cycle=1))
    mind.observe(seen(1, 1.0))
    mind.observe(seen(2, 2.0, J3=8.5, cycle=2))
    mind.observe(seen(3, 3.0, J3=None, cycle=2))
    event = mind.observe(seen(4, 4.0)).events[0]
    assert event.context.fields == {
        "recent_events": 1, "recent_entity": 1, "since_event_s": 3.0, "since_entity_s": 3.0, "since_same_s": 3.0,
        "recent_stop": 1, "since_stop_s": 2.0, "load": 8.5, "cycle_s": 2.0,
    }  # fmt: skip
    assert event.observations == 3


def test_a_domain_that_names_some_of_the_history_gets_only_that() -> None:
    mind = scripted({0: [Shown(label="stop")], 1: [Found(fields={})]}, 'channels = ["arm/*"]\n[fields]\nsince_stop_s = {}\n')
    mind.observe(seen(0, 0.0))
    assert mind.observe(seen(1, 4.0)).events[0].context.fields == {"since_stop_s": 4.0}


def test_an_unknown_detector_setting_or_placeholder_is_refused_with_a_way_out() -> None:
    head = 'name = "x"\nversion = 1\nsays = ""\n[[detect]]\nkind = "k"\n'
    with pytest.raises(DomainError, match=r"detect 1 names detector 'bnad'; use one of band, conditions"):
        registrar(head + 'detector = "bnad"\n')
    with pytest.raises(DomainError, match=r"unknown field `widht`; it knows width"):
        registrar(head + 'detector = "band"\nsettings = { widht = 2.0 }\n')
    with pytest.raises(DomainError, match=r"detect 'k' \(band\): settings: Expected `float` > 0.0 - at `\$.phase_s`"):
        registrar(head + 'detector = "band"\nsettings = { phase_s = 0.0 }\n')
    with pytest.raises(DomainError, match=r"settings.match is no regular expression"):
        registrar(head + 'detector = "text"\nsettings = { match = "(" }\n')
    with pytest.raises(DomainError, match=r"settings.criticality: 'FATAL'; write name=number"):
        registrar(head + 'detector = "conditions"\nsettings = { criticality = ["FATAL"] }\n')
    with pytest.raises(DomainError, match=r"nothing is called \{joint\}"):
        registrar(head + 'detector = "band"\nentity = "{joint}"\n')


def test_a_state_of_another_shape_is_refused_by_name() -> None:
    with pytest.raises(DomainError, match="the recorded state of detect/0/band/odd"):
        registrar().restore({"detect/0/band/odd": b"\xc0\xc0"})


def test_a_detector_that_raises_is_named() -> None:
    class Broken(Scripted):
        def observe(self, observation: Observation) -> list[Found | Shown | Offered]:
            raise ZeroDivisionError

    toml = 'name = "x"\nversion = 1\nsays = ""\n[[detect]]\nkind = "k"\ndetector = "own"\n'
    mind = registrar(toml, {"own": lambda spec, domain: Broken({})})
    with pytest.raises(ZeroDivisionError) as raised:
        mind.observe(seen(0, 0.0, x=1))
    assert "detect/0/own/k at position 0" in raised.value.__notes__[0]


def test_many_events_leave_a_state_of_bounded_size() -> None:
    script = {p: [Found(fields={"n": p}, entity=f"e{p}"), Shown(label="stop")] for p in range(8000)}
    mind, registered = scripted(script), Registered()
    for position in range(8000):
        registered = mind.observe(seen(position, position))
    assert registered.events
    assert sum(map(len, mind.changed().values())) < 1_500_000
