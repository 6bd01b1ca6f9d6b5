"""A small domain with every table filled, events and episodes in it, and hypothesis strategies for worse ones."""

from __future__ import annotations

from hypothesis import strategies as st

from wakeful.facts.asking import Episode
from wakeful.facts.domain import (
    Cause,
    DomainSpec,
    EvidenceSource,
    Fault,
    FieldSpec,
    Guideline,
    Hazard,
    OutcomeSpec,
    Route,
)
from wakeful.facts.events import Context, Event, Relation
from wakeful.facts.time import Stamp, to_ns
from wakeful.facts.values import Field
from wakeful.testing import Script

NOW_S = 10_000.0

DOMAIN = DomainSpec(
    name="depot",
    version=3,
    says="a small depot",
    fields={"load": FieldSpec(low=0.0, high=1.0), "temperature_c": FieldSpec(low=0.0, high=100.0)},
    outcome=OutcomeSpec(labels=("none", "stop", "drop"), within_s=60.0),
    evidence=(
        EvidenceSource(topic="heat", channels=("arm/temperature_*",), every_s=2.0, fields=("temperature_c",)),
        EvidenceSource(topic="reading", channels=(), every_s=4.0, fields=("current_a",)),
    ),
    guideline=(Guideline(treat="planning", because="go round", when={"state": "blocked"}),),
    hazard=(
        Hazard(name="stop", severity=2, exposure=0.8, likelihood=0.2, when={"kind": "current_high"}, control="slow down"),
        Hazard(name="falls", severity=4, exposure=0.5, likelihood=0.3, when={"state": "unstable"}, control="keep away"),
    ),
    fault=(
        Fault(
            name="worn gear",
            prior=0.05,
            causes={"current_high": 0.8, "temperature_c>70": 0.6, "stop": 0.5},
            check="listen to the gear",
            remedy="replace the gear",
        ),
        Fault(name="collision", prior=0.02, causes={"current_high": 0.9, "state=unstable": 0.7}, check="look", remedy="clear"),
        Fault(name="hot day", prior=0.1, causes={"temperature_c>70": 0.5}),
    ),
    route=(
        Route(start="dock", end="hall", cost=2.0),
        Route(start="hall", end="shelf", cost=3.0),
        Route(start="dock", end="yard", cost=4.0),
        Route(start="yard", end="shelf", cost=4.0),
        Route(start="shelf", end="loft", cost=1.0),
    ),
    cause=(
        Cause(cause="temperature_trend", effect="current_high", within_s=600.0, strength=0.6, because="heat thins the grease"),
        Cause(cause="current_high", effect="stop", within_s=60.0, strength=0.4, because="the arm protects itself"),
        Cause(cause="door_open", effect="temperature_trend", within_s=900.0, strength=0.3),
    ),
)

#: A domain that says nothing but its name.
BARE = DomainSpec(name="bare", version=1, says="nothing is known")


def event(
    kind: str = "current_high",
    entity: str = "J3",
    id: str = "now",
    at_s: float = NOW_S,
    deadline_s: float | None = None,
    relation: Relation = Relation.CHANGED,
    context: Context | None = None,
    says: str = "",
    **fields: Field,
) -> Event:
    """An event at a time, with these fields."""
    return Event(
        id=id,
        kind=kind,
        entity=entity,
        source="test",
        position=7,
        stamp=Stamp(source_ns=to_ns(at_s), received_ns=to_ns(at_s)),
        relation=relation,
        fields=fields,
        context=context or Context(),
        deadline_s=deadline_s,
        says=says,
    )


def episode(
    id: str,
    before_s: float,
    kind: str = "current_high",
    entity: str = "J3",
    likeness: float = 0.9,
    outcome: str = "",
    treatment: str = "diagnosis",
    verdict: str = "",
    **fields: Field,
) -> Episode:
    """An episode so long before the event."""
    return Episode(
        event=id,
        kind=kind,
        entity=entity,
        at_ns=to_ns(NOW_S - before_s),
        likeness=likeness,
        treatment=treatment,
        outcome=outcome,
        predicted=outcome,
        verdict=verdict,
        fields=fields,
    )


def script(*episodes: Episode, **more: object) -> Script:
    """A script that starts when the event is there."""
    return Script(episodes=episodes, now_s=NOW_S, **more)  # type: ignore[arg-type]


_NAMES = (
    "load",
    "temperature_c",
    "state",
    "value",
    "limit",
    "slope_per_s",
    "slope_per_min",
    "distance_m",
    "speed_mps",
    "tilt_deg",
    "tilt_rate_dps",
    "tilt_limit_deg",
    "start",
    "goal",
    "blocked",
    "channel",
    "current_a",
)
_WORDS = st.sampled_from(
    ("dock", "hall", "shelf", "loft", "dock-hall", "hall->shelf", "blocked", "unstable", "arm/temperature_3", "", "J3", "x\ny")
)
# a vector with NaN in it can't be recorded; a field that is NaN is recorded as null
_NUMBERS = st.one_of(st.floats(), st.integers(-(2**60), 2**60), st.floats(-100.0, 100.0))
_VALUES = st.one_of(
    st.none(),
    st.booleans(),
    _NUMBERS,
    _WORDS,
    st.text(max_size=12),
    st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=3).map(tuple),
)
_KINDS = st.sampled_from(("current_high", "temperature_trend", "route_blocked", "stop", "door_open", "object"))
_ENTITIES = st.sampled_from(("J3", "dock", "hall", "arm/temperature_3", "cup 1", ""))


fields = st.dictionaries(st.one_of(st.sampled_from(_NAMES), st.text(min_size=1, max_size=8)), _VALUES, max_size=8)

events = st.builds(
    Event,
    id=st.just("now"),
    kind=_KINDS,
    entity=_ENTITIES,
    source=st.just("test"),
    position=st.just(1),
    stamp=st.just(Stamp(source_ns=to_ns(NOW_S), received_ns=to_ns(NOW_S))),
    relation=st.sampled_from(Relation),
    fields=fields,
    context=st.builds(Context, task=_WORDS, zone=_WORDS, safety=st.booleans(), fields=fields),
    criticality=st.sampled_from((0, 1, 2, 3)),
    deadline_s=st.one_of(st.none(), st.floats(0.0, 200.0)),
    says=st.text(max_size=30),
)

episodes = st.lists(
    st.builds(
        Episode,
        event=st.integers(0, 30).map(lambda at: f"e{at:02}"),
        kind=_KINDS,
        entity=_ENTITIES,
        at_ns=st.integers(-5, 2000).map(lambda s: to_ns(NOW_S - s)),
        likeness=st.floats(0.0, 1.0),
        treatment=st.sampled_from(("description", "diagnosis", "analogy", "", "planning")),
        outcome=st.sampled_from(("", "none", "stop", "drop", "unheard of")),
        verdict=st.sampled_from(("", "supported", "contradicted", "undecided")),
        fields=fields,
    ),
    max_size=12,
    unique_by=lambda each: each.event,
).map(tuple)

domains = st.sampled_from((DOMAIN, BARE))

priors = st.sampled_from(({}, {"none": 0.9, "stop": 0.08, "drop": 0.02}, {"none": 1.0, "unheard of": 0.3}, {"stop": 0.0}))
