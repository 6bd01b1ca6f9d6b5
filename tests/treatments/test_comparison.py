import msgspec
import pytest

from tests.treatments.worlds import DOMAIN, episode, event, script
from wakeful.facts.asking import Episode
from wakeful.facts.domain import FieldSpec
from wakeful.testing import ScriptedMind
from wakeful.treatments.comparison import Comparison, Row, comparison


def compared(*episodes: Episode, **fields: object) -> Comparison:
    result = ScriptedMind(DOMAIN, "auto", script(*episodes)).run(comparison, event(**fields))  # type: ignore[arg-type]
    assert isinstance(result, Comparison)
    return result


def row(result: Comparison, name: str) -> Row:
    return next(each for each in result.rows if each.name == name)


PAST = tuple(episode(f"o{at}", 60.0 * (at + 1), load=0.30 + 0.01 * (at % 3), state="normal") for at in range(9))
PEERS = tuple(
    episode(f"p{at}", 30.0 * (at + 1), entity=f"J{at % 2}", load=0.5 + 0.02 * (at % 4), state="normal") for at in range(8)
)


def test_a_number_is_put_beside_its_own_past_and_its_peers() -> None:
    load = row(compared(*PAST, *PEERS, load=0.9), "load")
    assert (load.own_usual, load.own_count) == (0.31, 9)
    assert (load.peers_usual, load.peers_count) == (pytest.approx(0.53), 8)
    assert load.own_z is not None
    assert load.own_z > 20.0
    assert load.effect == pytest.approx((1 * 8 - 9 * 8) / (10 * 8))
    assert load.unusual


def test_how_a_detector_found_something_is_not_compared_unless_the_domain_says_so() -> None:
    own = [episode(f"b{at}", 60.0 * (at + 1), value=1.0, usual=0.0, deviation=4.0 + 0.1 * (at % 3)) for at in range(8)]
    found = event(value=1.0, usual=9.0, deviation=20.0)
    result = ScriptedMind(DOMAIN, "auto", script(*own)).run(comparison, found)
    assert isinstance(result, Comparison)
    assert [each.name for each in result.rows] == ["value"]
    fields = {**DOMAIN.fields, "deviation": FieldSpec(compared=True), "value": FieldSpec(compared=False)}
    told = ScriptedMind(msgspec.structs.replace(DOMAIN, fields=fields), "auto", script(*own)).run(comparison, found)
    assert isinstance(told, Comparison)
    assert told.unusual == ("deviation",)


def test_it_says_whose_events_it_compared_with() -> None:
    assert "compared with its own 9 earlier events and 8 events of 2 peers" in compared(*PAST, *PEERS, load=0.9).says


def test_a_value_like_its_past_and_peers_is_usual() -> None:
    result = compared(*PAST, load=0.31, state="normal")
    assert result.unusual == ()
    assert "nothing unusual in it" in result.says


def test_a_word_is_unusual_where_hardly_anybody_shares_it() -> None:
    result = compared(*PAST, load=0.31, state="hot")
    assert row(result, "state").share == 0.0
    assert result.unusual == ("state",)
    assert "state hot (shared by 0 % of them)" in result.says


def test_a_shift_of_its_own_level_is_dated() -> None:
    earlier = [episode(f"l{at}", 1_000.0 + 60.0 * at, load=0.2 + 0.001 * (at % 3)) for at in range(8)]
    later = [episode(f"h{at}", 60.0 + 60.0 * at, load=0.8 + 0.001 * (at % 3)) for at in range(8)]
    load = row(compared(*earlier, *later, load=0.8), "load")
    assert load.shifted_s == 480.0  # when the first of the higher values was seen
    assert (load.shifted_from, load.shifted_to) == (pytest.approx(0.2, abs=0.01), pytest.approx(0.8, abs=0.01))


def test_events_that_come_later_are_no_past() -> None:
    assert compared(episode("future", -60.0, load=0.5), load=0.5).past == 0


def test_confidence_grows_with_what_it_is_compared_with() -> None:
    assert (
        compared(*PAST[:2], load=0.3).confidence
        < compared(*PAST, load=0.3).confidence
        < compared(*PAST, *PEERS, load=0.3).confidence
    )


def test_where_nothing_is_unusual_it_says_in_what_another_event_might_be() -> None:
    peers = [msgspec.structs.replace(each, event=f"p{each.event}", entity="J5") for each in PAST]
    assert compared(*PAST, *peers, load=0.31, state="normal").would_change == ("an event of J3 that is unusual in its load",)
    words = [msgspec.structs.replace(each, fields={"state": "normal"}) for each in (*PAST, *peers)]
    assert compared(*words, state="normal").would_change == ("an event of J3 that is unusual in its attributes",)
