"""Typed lines in any order: hypothesis strategies for what reads journals."""

from __future__ import annotations

from hypothesis import strategies as st

from tests.journal.builder import WINDOW_S, decision, raw
from wakeful.facts.asking import Kind
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, ModelCard, Verdict
from wakeful.facts.lines import (
    Acted,
    Admitted,
    Answered,
    AnyRecord,
    Asked,
    Concluded,
    Created,
    Decided,
    Duplicate,
    Finished,
    Gained,
    Judged,
    Line,
    Moved,
    Noted,
    Opened,
    Published,
    Refused,
    Reopened,
    TrainingAsked,
    Trusted,
    Witnessed,
)
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Forecast
from wakeful.facts.time import Stamp

_process = st.integers(0, 4)
_event = st.sampled_from(["", "e1", "e2", "e3"])
_label = st.sampled_from(["", "none", "stop"])
_ns = st.integers(-(10**18), 10**18)
_probability = st.floats(allow_nan=False, allow_infinity=False, min_value=-1, max_value=2)
_text = st.text(max_size=8)


def _events() -> st.SearchStrategy[Event]:
    return st.builds(
        Event,
        id=_event,
        kind=st.sampled_from(["a", "b"]),
        entity=_text,
        source=_text,
        position=st.integers(0, 9),
        stamp=st.builds(Stamp, source_ns=_ns),
        criticality=st.sampled_from([0, 1, 2, 3]),
        truth_treatment=st.sampled_from([None, "diagnosis", "memory"]),
        says=_text,
    )


def _decisions() -> st.SearchStrategy[object]:
    return st.builds(
        decision,
        treatment=st.sampled_from(["diagnosis", "memory"]),
        mode=st.sampled_from(["auto", "delib", "fallback"]),
        novelty=_probability,
        model=st.integers(0, 3),
        rests_on=st.lists(st.integers(0, 3), max_size=2).map(tuple),
    )


def _forecasts() -> st.SearchStrategy[Forecast]:
    return st.builds(
        Forecast, label=_label, probability=_probability, probabilities=st.dictionaries(_label, _probability, max_size=2)
    )


def _cards() -> st.SearchStrategy[ModelCard]:
    number = st.integers(0, 3)
    return st.builds(
        ModelCard, version=number, base=number, watermark=number, seed=number, epochs=number, blob=_text, accepted=st.booleans()
    )


def _experiences() -> st.SearchStrategy[Experience]:
    return st.builds(
        Experience,
        id=st.integers(0, 3),
        event=_event,
        process=_process,
        treatment=_text,
        treatment_label=_text,
        predicted=_label,
        outcome=_label,
        verdict=st.sampled_from(Verdict),
        mode=_text,
    )


def _results() -> st.SearchStrategy[object]:
    return st.sampled_from([raw({"says": "it is warm", "confidence": 0.5}), raw(["no object"]), raw({"says": 3}), raw(None)])


def any_record() -> st.SearchStrategy[AnyRecord]:
    """Any record with any values of its types, about a few processes and events."""
    number = st.integers(0, 3)
    kind = st.sampled_from(Kind)
    return st.one_of(
        st.builds(
            Opened, source=_text, digest=_text, domain=_text, domain_version=number, offset_ns=_ns, seed=number, resumed_at=number
        ),
        st.builds(Finished, source=_text, observations=number),
        st.builds(Admitted, event=_events()),
        st.builds(Duplicate, event=_event, source=_text, position=number),
        st.builds(Refused, source=_text, position=number, reason=_text, event=_event),
        st.builds(
            Created,
            process=_process,
            event=_event,
            treatment=_text,
            criticality=number,
            parent=_process,
            reopens=_process,
            deadline_ns=st.none() | _ns,
        ),
        st.builds(Decided, process=_process, event=_event, decision=_decisions()),
        st.builds(
            Moved, process=_process, before=st.sampled_from(State), trigger=st.sampled_from(Trigger), after=st.sampled_from(State)
        ),
        st.builds(Asked, process=_process, seq=number, kind=kind, key=_text, expires_ns=st.none() | _ns),
        st.builds(Answered, process=_process, seq=number, kind=kind, key=_text, error=_text, cost_usd=_probability),
        st.builds(
            Concluded,
            process=_process,
            event=_event,
            treatment=_text,
            mode=_text,
            result=_results(),
            forecast=st.none() | _forecasts(),
            closes_ns=st.none() | st.just(WINDOW_S * 10**9) | _ns,
        ),
        st.builds(
            Witnessed,
            outcome=st.builds(Outcome, id=st.sampled_from(["o1", "o2"]), topic=_text, entity=_text, label=_label, at_ns=_ns),
        ),
        st.builds(
            Judged,
            process=_process,
            event=_event,
            predicted=_label,
            label=_label,
            verdict=st.sampled_from(Verdict),
            outcome=st.sampled_from(["", "o1", "o2"]),
        ),
        st.builds(Gained, experience=_experiences()),
        st.builds(TrainingAsked, training=number, base=number, watermark=number, seed=number, epochs=number, publish_ns=_ns),
        st.builds(Published, training=number, card=_cards()),
        st.builds(Trusted, treatment=_text, before=_probability, after=_probability, why=_text, experience=number),
        st.builds(Reopened, process=_process, reopens=_process, event=_event, because=_text),
        st.builds(Acted, who=_text, act=st.sampled_from(["hold", "release"]), process=_process, why=_text),
        st.builds(Noted, what=_text, detail=_text, process=_process, event=_event),
    )


def any_lines(max_size: int = 40) -> st.SearchStrategy[list[Line]]:
    """Lines of any records with any positions and instants."""
    return st.lists(st.builds(Line, position=st.integers(0, 50), at_ns=_ns, record=any_record()), max_size=max_size)
