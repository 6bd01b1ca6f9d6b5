import pytest

from tests.treatments.worlds import DOMAIN, episode, event, script
from wakeful.facts.asking import Episode
from wakeful.testing import ScriptedMind
from wakeful.treatments.memory import Memory, memory


def remembered(*episodes: Episode, mode: str = "auto", **fields: object) -> Memory:
    result = ScriptedMind(DOMAIN, mode, script(*episodes)).run(memory, event(**fields))  # type: ignore[arg-type]
    assert isinstance(result, Memory)
    return result


def test_what_differs_is_told_with_the_old_value_and_since_when() -> None:
    result = remembered(
        episode("a", 90.0, load=0.2, state="normal"),
        episode("b", 300.0, load=0.21, state="normal"),
        episode("c", 500.0, load=0.9, state="normal"),
        load=0.6,
        state="normal",
    )
    [load] = result.differs
    assert (load.name, load.was, load.now, load.held_s) == ("load", 0.2, 0.6, 90.0)
    assert load.sightings == 2  # it was so twice in a row, before that it was something else
    assert result.unchanged == ("state",)
    assert "load 0.6 (was 0.2), changed within the last 1.5 min" in result.says


def test_a_difference_within_the_tolerance_of_the_fields_range_is_none() -> None:
    assert remembered(episode("a", 90.0, temperature_c=40.0), temperature_c=44.0).differs == ()
    assert len(remembered(episode("a", 90.0, temperature_c=40.0), temperature_c=46.0).differs) == 1


def test_only_cases_that_are_like_enough_count_as_having_happened_before() -> None:
    near = episode("n", 100.0, entity="J1", outcome="stop", verdict="supported", state="hot", load=0.5)
    far = episode("f", 100.0, entity="J1", outcome="none", state="cold", load=0.5)
    other = episode("o", 100.0, kind="object", entity="J1", outcome="none", state="hot", load=0.5)
    result = remembered(near, far, other, state="hot", load=0.4)
    assert result.happened == 1
    assert [(row.outcome, row.count) for row in result.endings] == [("stop", 1)]
    assert "it happened 1 time before: 1 ended in stop" in result.says


def test_cases_that_are_still_open_are_named_as_what_would_change_it() -> None:
    result = remembered(episode("n", 100.0), episode("m", 200.0, outcome="none"))
    assert [(row.outcome, row.count) for row in result.endings] == [("none", 1), ("", 1)]
    assert any("the end of 1 like case," in each for each in result.would_change)


def test_a_memory_fades_with_time_and_less_if_it_was_refreshed() -> None:
    fresh, old = remembered(episode("a", 60.0)), remembered(episode("a", 7_200.0))
    often = remembered(*(episode(f"a{at}", 7_200.0 + at) for at in range(4)))
    assert fresh.retention > often.retention > old.retention
    assert old.retention == pytest.approx(0.25, abs=1e-3)  # two half-lives


def test_an_entity_that_was_never_seen_is_not_known() -> None:
    result = remembered(episode("a", 60.0, entity="J9", likeness=0.1))
    assert not result.known
    assert "not remembered at all" in result.says


def test_the_event_itself_is_no_memory_of_it() -> None:
    assert not remembered(episode("now", 0.0)).known


def test_an_earlier_sighting_that_differs_in_nothing_is_named_where_the_last_one_differs() -> None:
    before = episode("before", 600.0, load=0.4, state="unstable")
    last = episode("last", 60.0, load=0.4, state="normal")
    result = ScriptedMind(DOMAIN, "auto", script(last, before)).run(memory, event(load=0.4, state="unstable"))
    assert isinstance(result, Memory)
    assert (result.as_before, result.as_before_s) == ("before", 600.0)
    assert "it was just so 10 min ago" in result.says
    other = ScriptedMind(DOMAIN, "auto", script(last)).run(memory, event(load=0.4, state="unstable"))
    assert isinstance(other, Memory)
    assert other.as_before == ""
