"""The sources that are heard: resuming, joining conditions, silence, and the counts beside admission's."""

from __future__ import annotations

import pytest

from wakeful.contracts.domain import Domain
from wakeful.domains.package import PackageDomain
from wakeful.domains.toml import parse_spec
from wakeful.facts.events import Condition, Draft, Phase
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Begin
from wakeful.registration import Sources

NOTHING_OF_ITS_OWN = """
name = "plain"
version = 1
says = "its events come registered"
robot = "r1"
outcome = { labels = ["none", "stop"], within_s = 5.0 }
"""


@pytest.fixture
def domain() -> Domain:
    return PackageDomain(parse_spec(NOTHING_OF_ITS_OWN, "test.toml"))


@pytest.fixture
def sources(domain: Domain) -> Sources:
    opened = Sources(domain, seed=7)
    opened.begin(Begin(source="log", digest="d1"))
    return opened


def draft(phase: Phase | None, position: int = 0) -> Draft:
    condition = None if phase is None else Condition(key="robot|dock|blocked", phase=phase)
    return Draft(kind="blocked", entity="dock", source="log", position=position, at_ns=5, condition=condition)


def test_an_unfinished_source_goes_on_after_its_cursor(sources: Sources) -> None:
    sources.states["log"].cursor = 41
    assert sources.begin(Begin(source="log", digest="d1")).resumed_at == 42


def test_a_finished_source_is_read_again_with_fresh_state_but_keeps_its_counts(sources: Sources) -> None:
    sources.join(draft(None))
    sources.states["log"].cursor = 41
    sources.end("log")
    assert sources.begin(Begin(source="log", digest="d1")).resumed_at == 0
    assert (sources.states["log"].cursor, sources.states["log"].offered) == (-1, 1)


def test_a_repeat_joins_the_condition_that_was_raised_until_it_is_cleared(sources: Sources) -> None:
    assert isinstance(sources.join(draft(Phase.RAISED, 0)), Draft)
    for phase, topic in ((Phase.REPEATED, "condition.repeated"), (Phase.CLEARED, "condition.cleared")):
        joined = sources.join(draft(phase, 1))
        assert isinstance(joined, Evidence)
        assert (joined.topic, joined.key) == (topic, "robot|dock|blocked")
    assert sources.join(draft(Phase.CLEARED, 2)) is None
    assert (sources.states["log"].offered, sources.states["log"].joined) == (2, 2)


def test_a_repeat_of_what_was_never_raised_is_the_raise_that_was_lost(sources: Sources) -> None:
    first = sources.join(draft(Phase.REPEATED))
    assert isinstance(first, Draft)
    assert first.condition is not None
    assert first.condition.phase is Phase.RAISED


def test_the_first_word_of_a_source_ends_no_silence(sources: Sources) -> None:
    assert [sources.hear("log", now_ns) for now_ns in (100, 100, 350)] == [0, 0, 250]


def test_restored_sources_go_on_as_they_stood(sources: Sources, domain: Domain) -> None:
    sources.join(draft(Phase.RAISED))
    state = {key: value for key, value in sources.changed().items() if value is not None}
    again = Sources(domain, seed=7)
    again.restore(sources.states, state)
    assert isinstance(again.join(draft(Phase.REPEATED)), Evidence)
    assert again.changed() == {}
